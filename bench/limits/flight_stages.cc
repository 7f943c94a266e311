// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/flight_stages.h"

#include <fmt/format.h>

#include <algorithm>

#include "flight/simulated/runner.h"

namespace kestrel::bench {

double FlightStages::AllStages_ms() const {
  double sum = 0;
  for (const auto& [name, ms] : stages_ms) sum += ms;
  return sum;
}

FlightStages StagesOfFlight(const std::string& scenario, double duration_s) {
  flight::LoadedScenario loaded =
      flight::LoadScenario(scenario, {"seed=3", "criteria={}", fmt::format("duration_s={}", duration_s)});
  flight::RunOptions options;
  options.video = false;
  FlightStages flown;
  loaded.simulator.draw_beside = true;
  const records::Summary by_two = flight::RunFlight(loaded, options).summary;
  flown.by_two = by_two.sim_s / by_two.wall_s;
  loaded.simulator.draw_beside = false;
  const flight::FlightResult by_one = flight::RunFlight(loaded, options);
  flown.by_one = by_one.summary.sim_s / by_one.summary.wall_s;
  for (const auto& [name, time] : by_one.summary.stages) flown.stages_ms[name] = time.mean_ms;
  flown.frame_s = by_one.summary.sim_s / static_cast<double>(std::max<std::size_t>(1, by_one.rows.size()));
  return flown;
}

}  // namespace kestrel::bench
