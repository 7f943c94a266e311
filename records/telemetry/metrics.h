// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mission/metric.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::mission {
struct MissionType;
}

namespace kestrel::records {

// Those of every mission.
const std::vector<mission::Metric>& CommonMetrics();
// Every metric that a run of any mission may have.
std::vector<mission::Metric> AllMetrics();

// Whether a metric is of what the flight code saw or wanted: without its decisions it cannot be had.
bool NeedsDecisions(const std::string& metric);

// What a flight did, judged by the truth alone. touch: the instant before the first touch-down. Metrics that
// do not apply (no fix, no goal, no landing) are not there. Those of every mission, and those that the type of
// the mission declares; null: of a flight whose mission is not known.
std::map<std::string, double> Metrics(const std::vector<LogRow>& rows, const std::optional<Truth>& touch,
                                      const mission::MissionType* type);

}  // namespace kestrel::records
