// SPDX-License-Identifier: Apache-2.0
#include "campaign/fly_row.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>

#include "config/stopwatch.h"
#include "scenarios/runner.h"

namespace kestrel {
namespace {

double PeakMemory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace

RunResult FlyRow(const RunOrder& order) {
  RunResult result;
  result.row = order.row;
  if (order.folder) result.execution.recording = order.folder->string();
  try {
    const LoadedScenario loaded = LoadScenario(order.scenario, order.overrides);
    RunOptions options;
    options.folder = order.folder;
    options.video = order.video;
    const auto start = std::chrono::steady_clock::now();
    const Summary summary = RunFlight(loaded, options).summary;
    result.execution.wall_s = SecondsSince(start);
    if (summary.complete) {
      result.status = summary.passed ? RunStatus::kPassed : RunStatus::kFailed;
      result.outcome = summary.outcome;
      result.metrics = summary.metrics;
      result.state_hash = fmt::format("{:016x}", summary.state_hash);
      result.image_hash = fmt::format("{:016x}", summary.image_hash);
    } else {
      result.outcome = summary.error;
    }
  } catch (const InputError& e) {
    result.status = RunStatus::kRefused;
    result.outcome = e.what();
  } catch (const std::exception& e) {
    result.outcome = e.what();
  }
  result.execution.peak_mib = PeakMemory_mib();
  return result;
}

}  // namespace kestrel
