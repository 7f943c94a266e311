// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"

namespace kestrel::scenarios {

std::vector<mission::TelemetryColumn> StabiliseColumns();

// By the true path of the camera (corner_motion.h): what is left, from 0.5 to 15 Hz, of how the corners of the view
// shook.
inline constexpr double kJitterFrom_hz = 0.5, kJitterUntil_hz = 15;
std::vector<mission::Metric> StabiliseMetrics();
void AddStabiliseMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
