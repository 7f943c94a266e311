// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "bench/timings/timed_work.h"
#include "bench/timings/timing_machine.h"

namespace kestrel::bench {

// A block of work and the calibrations right before it.
struct CalibratedBlock {
  WorkTimes work, arithmetic, memory;
};

// The blocks of each work in one process.
using TimingRound = std::map<std::string, std::vector<CalibratedBlock>>;

// A run of `bench timings` as it is kept.
struct TimingRecord {
  std::string version;
  TimingMachine machine;
  std::vector<TimingRound> rounds;
};

// JSON: {"kind": "kestrel timings", "format": 1, "version", "machine", "columns", "rounds": [{NAME: [[number of each
// column], ...]}, ...]}.
std::string ToJson(const TimingRecord& record);

// Mistakes: the file is not there, or not of that kind. At least two rounds, each of the same work.
TimingRecord ReadTimingRecord(const std::filesystem::path& file, Mistakes& mistakes);

}  // namespace kestrel::bench
