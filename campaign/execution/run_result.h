// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace kestrel::campaign {

// How a run of a campaign ended.
enum class RunStatus {
  kPassed,    // it met its scenario's criteria
  kFailed,    // it did not
  kBrokeOff,  // the flight ended itself: a state that is no number, a disk that is full
  kRefused,   // the row's values make no valid scenario together
  kCrashed,   // its worker died of it
  kTimedOut,  // it took longer than it may, and its worker was ended
};
std::string_view NameOf(
    RunStatus status);  // "passed", "failed", "broke off", "refused", "crashed", "timed out"
RunStatus RunStatusOf(std::string_view name);  // throws std::runtime_error for another name

// A run that was flown.
struct RunResult {
  std::int64_t row = 0;
  RunStatus status = RunStatus::kBrokeOff;
  std::string outcome;                    // as the summary has it, or why it did not end well
  std::map<std::string, double> metrics;  // unit in the name; one that does not apply is not there
  std::string state_hash, image_hash;     // 16 hexadecimal digits; empty when it was not flown to its end

  // What depends on the machine: kept apart from the results, which do not.
  struct Execution {
    int worker = 0;
    double wall_s = 0;
    double orchestration_s = 0;  // of it, not spent on flying: reading the scenario, handing over, storing
    double peak_mib = 0;         // of the worker's memory until then
    std::string log;             // the last that the worker said, of a run that did not end well
    std::string recording;       // folder of its records, if any
  } execution;
};

}  // namespace kestrel::campaign
