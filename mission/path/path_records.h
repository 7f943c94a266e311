// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "mission/mission_type.h"
#include "mission/path/waypoint_path.h"

// What missions whose report is a PathReport declare.
namespace kestrel::mission {

std::vector<TelemetryColumn> PathColumns();

// How far the aircraft truly is from where it is meant to be: the errors of the autopilot's own navigation are in
// them.
std::vector<Metric> PathMetrics();
void AddPathMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics);

// What the aircraft's autopilot does not give, of `flight.path`.
void CheckPathLimits(const PathParameters& path, const AircraftLimits& limits, const Place& where,
                     Mistakes& mistakes);

}  // namespace kestrel::mission
