// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kestrel::bench {

// What a block of work took.
struct WorkTimes {
  double processor_ms = 0;  // of all threads of this process
  double wall_ms = 0;
  double pieces = 1;  // that it was: frames, seconds flown
};

// Runs a clock from its making on.
class WorkClock {
 public:
  WorkClock();
  WorkTimes Taken(double pieces) const;

 private:
  double processor_ms_, wall_ms_;
};

// A block of work that is the same each time, in every build: some tens of milliseconds.
using Block = std::function<WorkTimes()>;

// What flights, campaigns and servers spend their time on, and the two calibrations. In the order of tables.
struct TimedWork {
  std::string name;
  std::string piece;  // what is counted
  int blocks = 5;     // in a process; more of what is noisy and short
};
std::vector<TimedWork> AllTimedWork();

// Calibrations: loops over nothing of Kestrel's, by which one hour's speed of a machine is told from another's.
inline constexpr const char* kArithmetic = "arithmetic";
inline constexpr const char* kMemory = "memory";

// Makes what the work needs. name: one of AllTimedWork. Throws InputError: there is no such work, or a model or
// scenario of it cannot be read.
Block PrepareWork(const std::string& name);

}  // namespace kestrel::bench
