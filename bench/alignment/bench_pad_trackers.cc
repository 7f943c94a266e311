// SPDX-License-Identifier: Apache-2.0
#include "bench/alignment/bench_pad_trackers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/pad_scene.h"
#include "geometry/tait_bryan.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::bench {
namespace {

constexpr int kFrames = 60;
constexpr double kRate_hz = 20;
constexpr std::array kHeights_m = {1.0, 2.0, 4.0, 8.0};
const std::array<std::string, 2> kMethods = {"klt", "icia"};

struct Score {
  int frames = 0, seen = 0, searched = 0;
  std::vector<double> error_m, turn_rad, ms;
};

}  // namespace

void BenchPadTrackers(flight::SeedRange seeds, std::vector<records::Figure>& table) {
  seeds.last = std::min(seeds.last, seeds.first + 4);
  PadScene scene;
  const flight::LoadedScenario& loaded = scene.loaded();
  const auto& camera = std::get<vision::Pinhole>(loaded.simulator.camera);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  fmt::print(
      "| height | tracker | frames seen % | searched | error mm, RMS | turn deg, RMS | ms mean, 99 % |\n");
  std::array<std::vector<double>, 2> all_ms;
  for (const double height_m : kHeights_m) {
    std::array<Score, 2> scores;
    for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
      const PadSway sway(seed, "bench pad trackers");
      std::vector<vision::PadTracker> trackers;
      for (const std::string& method : kMethods) {
        vision::PadTrackerOptions options = loaded.scenario.pilot.tracker;
        options.method = method;
        trackers.emplace_back(loaded.pad, camera, options);
      }
      const sim::ImageSensor sensor = scene.Sensor(seed);
      for (int k = 0; k < kFrames; ++k) {
        const Pose X_TC = sway.X_TC(height_m, k / kRate_hz);
        const cv::Mat image = sensor.Expose(scene.Render(X_TC), k);
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
          Score& score = scores[m];
          const double start_ms = ThreadCpu_ms();
          const auto seen = trackers[m].Track(image, std::nullopt);
          const double ms = ThreadCpu_ms() - start_ms;
          ++score.frames, score.seen += seen.has_value();
          if (!seen) continue;
          const Pose X_TC_seen = seen->X_CT.Inverse();
          score.error_m.push_back((X_TC_seen.p - X_TC.p).norm());
          score.turn_rad.push_back(LogRotation(X_TC_seen.R * X_TC.R.conjugate()).norm());
          score.searched += seen->found;
          if (!seen->found) score.ms.push_back(ms), all_ms[m].push_back(ms);
        }
      }
    }
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      const Score& s = scores[m];
      fmt::print("| {:4g} m | {:<7} | {:13.1f} | {:8} | {:13.2f} | {:13.3f} | {:6.2f} {:6.2f} |\n", height_m,
                 kMethods[m], 100.0 * s.seen / s.frames, s.searched, 1e3 * Rms(s.error_m),
                 Degrees(Rms(s.turn_rad)), Mean(s.ms), Quantile(s.ms, 0.99));
      table.push_back({fmt::format("pad at {:g} m, {}: position RMSE, vision alone", height_m, kMethods[m]),
                       Rms(s.error_m),
                       "m",
                       {},
                       false,
                       ""});
    }
  }
  cv::setNumThreads(threads);
  for (std::size_t m = 0; m < kMethods.size(); ++m)
    table.push_back({fmt::format("pad, {}: mean a frame", kMethods[m]), Mean(all_ms[m]), "ms", 3, false, ""});
}

}  // namespace kestrel::bench
