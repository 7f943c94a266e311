// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kestrel::bench {

// What one core and its memory give, each the best of several tries: bounds that no program passes.
struct MemoryRate {
  std::string level;
  std::size_t bytes = 0;  // of the buffer that was read
  double read_gb_s = 0;   // in order, by whole vectors
  double random_reads_per_us =
      0;  // reads of 8 bytes from addresses in no order, none of which waits for another
};

struct MachineRates {
  std::string instruction_set;
  double multiply_adds_gflop_s = 0;  // floats, two operations each
  double divisions_per_ns = 0;       // floats
  std::vector<MemoryRate> memory;    // the nearest first
};

MachineRates MeasureMachineRates();

// Of a buffer this large: that of the smallest buffer measured that is as large, or of the largest.
const MemoryRate& RateFor(const MachineRates& rates, double bytes);

}  // namespace kestrel::bench
