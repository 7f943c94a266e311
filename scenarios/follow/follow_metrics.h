// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

std::vector<mission::TelemetryColumn> FollowColumns();

// How well a balloon, the first target, was followed, by the truth: its image in a level camera beside what
// was wanted of it. None of a flight that never followed one.
std::vector<mission::Metric> FollowMetrics();
void AddFollowMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
