// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/bench_landings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "base/statistics.h"

namespace kestrel::bench {
namespace {

struct Landing {
  const char *name, *scenario;
  std::vector<std::string> overrides;
  double max_error_m;  // 95th percentile
};

void AddLanding(const Landing& landing, flight::SeedRange seeds, int jobs,
                std::vector<records::Figure>& table) {
  const std::string name = std::string("landing ") + landing.name;
  const auto flights = flight::FlyAll(landing.scenario, landing.overrides, seeds, jobs, name);
  const auto landed = std::count_if(flights.begin(), flights.end(), [](const flight::FlownScenario& f) {
    return f.summary.outcome == "landed" && f.summary.metrics.contains("rest_error_m");
  });
  const std::vector<double> error = flight::Values(flights, "touchdown_error_m");
  table.push_back({name + ", share that landed",
                   static_cast<double>(landed) / static_cast<double>(flights.size()), "", 1, true, ""});
  table.push_back({name + ", touch-down error, median", Quantile(error, 0.5), "m", {}, false, ""});
  table.push_back({name + ", touch-down error, 95th percentile", Quantile(error, 0.95), "m",
                   landing.max_error_m, false, ""});
}

// The worst of all seeds.
void AddCarried(int test, flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const std::string scenario = fmt::format("vicon_{}", test), name = fmt::format("thesis 3.4, test {}", test);
  const auto flights = flight::FlyAll(scenario, {}, seeds, jobs, name);
  const auto worst = [&](const char* metric) { return Largest(flight::Values(flights, metric)); };
  table.push_back({name + ", x across", worst("landmark_x_rmse_m"), "m", 0.02, false, "0.3"});
  table.push_back({name + ", y across", worst("landmark_y_rmse_m"), "m", 0.02, false, "0.3"});
  table.push_back({name + ", z in depth", worst("landmark_z_rmse_m"), "m", 0.03, false, "0.3"});
  // Through the rotation that is seen, which a small landmark far away tells less well.
  table.push_back(
      {name + ", the camera in the room, across", worst("camera_x_rmse_m"), "m", 0.02, false, ""});
  table.push_back(
      {name + ", the camera in the room, in depth", worst("camera_y_rmse_m"), "m", 0.03, false, ""});
  table.push_back({name + ", the camera in the room, up", worst("camera_z_rmse_m"), "m", 0.02, false, ""});
  table.push_back({name + ", chain of homographies alone, off where it broke",
                   worst("chain_drift_m"),
                   "m",
                   {},
                   false,
                   ""});
  const std::vector<double> within = flight::Values(flights, "within_95_share");
  table.push_back({name + ", within its 95 % ellipsoid, least share",
                   *std::min_element(within.begin(), within.end()),
                   "",
                   {},
                   true,
                   ""});
}

}  // namespace

void BenchLandings(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const Landing landings[] = {{"by corners (klt)", "landing", {}, 0.12},
                              {"by the whole picture (icia)", "landing", {"pilot.tracker.method=icia"}, 0.12},
                              {"on nested tags", "landing_nested", {}, 0.12},
                              {"on a white H", "landing_h", {}, 0.2},
                              {"on a printed pad, by a real lens", "landing_printed", {}, 0.12},
                              {"by fuzzy height, start 1", "landing_fuzzy_1", {}, 0.12},
                              {"by fuzzy height, start 2", "landing_fuzzy_2", {}, 0.12},
                              {"by fuzzy height, start 3", "landing_fuzzy_3", {}, 0.12}};
  for (const Landing& each : landings) AddLanding(each, seeds, jobs, table);
  for (int test = 1; test <= 4; ++test) AddCarried(test, seeds, jobs, table);
}

}  // namespace kestrel::bench
