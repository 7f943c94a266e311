// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "bench/timings/measure_timings.h"

namespace kestrel::bench {

// What a frame, a flight and its start cost, and whether that is less or more than it was.
struct TimingOptions {
  int rounds = 16;  // processes of each program
  TimingClock clock = TimingClock::kProcessor;
  // What to compare with: a program kestrel of another build, which is timed in turn with this one, or what
  // this bench wrote before. Empty: nothing.
  std::filesystem::path against;
  std::filesystem::path json;  // where the run is kept; empty: nowhere
};

// Prints a table; returns whether nothing is slower. Throws InputError: what to compare with is not there, of another
// kind, or of another machine.
bool BenchTimings(const TimingOptions& options);

}  // namespace kestrel::bench
