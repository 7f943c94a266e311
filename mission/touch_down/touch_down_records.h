// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/metric.h"
#include "mission/mission_type.h"
#include "mission/touch_down/go_around.h"

// What missions that touch down by a GoAround declare.
namespace kestrel::mission {

inline constexpr const char* kAborted = "aborted";  // the outcome

// Of a frame: the limits in force, how many approaches it took, the wind as the aircraft knows it.
struct TouchDownReport : MissionReport {
  TouchDownLimits limits;
  int attempt = 1;
  double wind_m_s = 0;
};

std::vector<TelemetryColumn> TouchDownColumns();
std::vector<Metric> TouchDownMetrics();
// By the metrics of the first touch, which must be there already if it touched.
void AddTouchDownMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::mission
