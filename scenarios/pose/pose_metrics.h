// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// What thesis 4.4.2 gives: how far the camera's fix is from what the autopilot makes of its own sensors,
// which is most of the autopilot's error. How far the fix is from the truth is among the metrics of every
// flight.
std::vector<mission::Metric> PoseMetrics();
void AddPoseMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
