// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/fly_row.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>

#include <chrono>
#include <fstream>
#include <string>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "flight/simulated/runner.h"
#include "vision/landmark/pad_features.h"

namespace kestrel::campaign {
namespace {

// Not getrusage's, which a process inherits from who started it, but where there is no /proc.
double PeakMemory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1024;
}

// What the search for a lost pad needs beside the images, before the textures are there, which take most of a worker's
// memory: the two are never there together, and of many flights some lose it.
void PrepareSearch(const flight::LoadedScenario& loaded) {
  if (!loaded.scenario.flight.type().looks_for_pad || loaded.pad.levels.empty() || !loaded.pad.tags.empty())
    return;
  if (const auto detector = vision::FeatureDetectorNamed(loaded.scenario.pilot.tracker.features))
    vision::PadFeatures::Prepare(loaded.pad, *detector);
}

}  // namespace

RunResult FlyRow(const RunOrder& order) {
  RunResult result;
  result.row = order.row;
  if (order.folder) result.execution.recording = order.folder->string();
  // What the flight before took is given back, or a worker would hold the most that it ever needed twice.
  malloc_trim(0);
  try {
    flight::LoadedScenario loaded = flight::LoadScenario(order.scenario, order.overrides, false);
    loaded.simulator.draw_beside = false;
    PrepareSearch(loaded);
    flight::RunOptions options;
    options.folder = order.folder;
    options.video = order.video;
    const auto start = std::chrono::steady_clock::now();
    const records::Summary summary = flight::RunFlight(loaded, options).summary;
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

}  // namespace kestrel::campaign
