// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/fly_all.h"

#include <fmt/format.h>
#include <unistd.h>

#include <limits>
#include <stdexcept>

#include "base/process/in_parallel.h"

namespace kestrel::flight {
namespace {

void SayWhatWasMissed(const records::Summary& flight, const std::string& title) {
  std::string lines;
  for (const records::Criterion& c : flight.criteria) {
    if (!c.passed)
      lines += fmt::format("{}, seed {}: {} {:.4g}, {} {:.4g}\n", title, flight.seed, c.name, c.value,
                           c.at_least ? "at least" : "at most", c.limit);
  }
  if (lines.empty()) return;
  if (isatty(STDERR_FILENO)) lines.insert(0, "\r\033[K");  // over the line of progress
  fmt::print(stderr, "{}", lines);
}

}  // namespace

std::vector<FlownScenario> FlyAll(const std::string& scenario, const std::vector<std::string>& overrides,
                                  SeedRange seeds, int jobs, const std::string& title) {
  std::vector<FlownScenario> flights;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    auto all = overrides;
    all.push_back(fmt::format("seed={}", seed));
    flights.push_back({LoadScenario(scenario, all), {}, {}});
  }
  InParallel(flights.size(), jobs, title, "flights", [&](std::size_t i) {
    FlightResult result = RunFlight(flights[i].loaded, {});
    if (!result.summary.complete)
      throw std::runtime_error(
          fmt::format("{}, seed {}: {}", scenario, flights[i].loaded.scenario.seed, result.summary.error));
    SayWhatWasMissed(result.summary, title);
    flights[i].summary = std::move(result.summary);
    flights[i].rows = std::move(result.rows);
  });
  return flights;
}

std::vector<double> Values(const std::vector<FlownScenario>& flights, const std::string& metric) {
  std::vector<double> values;
  for (const FlownScenario& flight : flights) {
    const auto found = flight.summary.metrics.find(metric);
    values.push_back(found != flight.summary.metrics.end() ? found->second
                                                           : std::numeric_limits<double>::infinity());
  }
  return values;
}

}  // namespace kestrel::flight
