// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "flight/simulated/scenario.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::flight {

// What is known before a flight in the simulator: its names, its seed, what scatter makes of its camera.
records::Summary BeginSummary(const Scenario& scenario);

// What the simulator itself leaves at the end: its time, its hashes, what its stages cost.
void AddSimulator(const sim::Simulator& simulator, records::Summary& summary);

// Holds the metrics to the limits. What could not be measured did not happen and is not met: no touch-down,
// no fix.
void Judge(const std::map<std::string, Limit>& limits, records::Summary& summary);
bool AllPassed(const std::vector<records::Criterion>& criteria);

}  // namespace kestrel::flight
