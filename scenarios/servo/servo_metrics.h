// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"

namespace kestrel::scenarios {

std::vector<mission::TelemetryColumn> ServoColumns();
std::vector<mission::Metric> ServoMetrics();
void AddServoMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
