// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/process/piped_process.h"
#include "bench/timings/timed_work.h"
#include "bench/timings/timing_machine.h"

namespace kestrel::bench {

// A program `kestrel`, of this build or another, as a process that times its own work when told to.
class TimedProgram {
 public:
  // Starts `PROGRAM bench timings --in-turn`. Throws InputError: that is no such program, or it says nothing within the
  // patience.
  explicit TimedProgram(const std::filesystem::path& program, double patience_s = 60);
  const std::string& version() const { return version_; }
  const TimingMachine& machine() const { return machine_; }
  const std::vector<std::string>& work() const { return work_; }  // names that it knows

  // A block of it, now. Throws std::runtime_error: the program ended, or could not do it.
  WorkTimes Time(const std::string& work);

 private:
  std::filesystem::path program_;
  PipedProcess process_;
  std::string version_;
  TimingMachine machine_;
  std::vector<std::string> work_;
};

}  // namespace kestrel::bench
