// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "flight/simulated/runner.h"
#include "flight/simulated/scenario.h"
#include "flight/simulated/seeds.h"

// Many flights of one scenario, and what their metrics come to: for benchmarks.
namespace kestrel::flight {

// A flight with what it was flown by.
struct FlownScenario {
  LoadedScenario loaded;
  records::Summary summary;
  std::vector<records::LogRow> rows;
};

// Flies a scenario once for each seed, several at a time; results in the order of the seeds, whatever the
// order of their ends. title: of the progress on a terminal; a criterion that is missed is told on standard
// error at once. Throws std::runtime_error if a flight breaks off.
std::vector<FlownScenario> FlyAll(const std::string& scenario, const std::vector<std::string>& overrides,
                                  SeedRange seeds, int jobs, const std::string& title);

// A metric of each flight; infinity where it has none.
std::vector<double> Values(const std::vector<FlownScenario>& flights, const std::string& metric);

}  // namespace kestrel::flight
