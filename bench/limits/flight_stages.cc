// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/flight_stages.h"

#include <fmt/format.h>

#include <algorithm>

#include "flight/simulated/runner.h"

namespace kestrel::bench {

FlightStages StagesOfFlight(const std::string& scenario, double duration_s) {
  constexpr int kTries = 3;
  flight::LoadedScenario loaded =
      flight::LoadScenario(scenario, {"seed=3", "criteria={}", fmt::format("duration_s={}", duration_s)});
  flight::RunOptions options;
  options.video = false;
  FlightStages flown;
  for (int i = 0; i < kTries; ++i) {
    loaded.simulator.draw_beside = true;
    const records::Summary by_two = flight::RunFlight(loaded, options).summary;
    flown.by_two = std::max(flown.by_two, by_two.sim_s / by_two.wall_s);
    loaded.simulator.draw_beside = false;
    const flight::FlightResult result = flight::RunFlight(loaded, options);
    const records::Summary& by_one = result.summary;
    if (by_one.sim_s / by_one.wall_s < flown.by_one) continue;
    flown.by_one = by_one.sim_s / by_one.wall_s;
    for (const auto& [name, time] : by_one.stages) flown.stages_ms[name] = time.mean_ms;
    flown.stages_ms["physics"] -= flown.stages_ms["render"] + flown.stages_ms["sensor"];
    flown.frame_s = by_one.sim_s / static_cast<double>(std::max<std::size_t>(1, result.rows.size()));
  }
  return flown;
}

}  // namespace kestrel::bench
