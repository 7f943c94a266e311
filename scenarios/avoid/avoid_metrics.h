// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// Whether the rows are of the mission "avoid", with targets to be met.
bool MeetsIntruders(const std::vector<records::LogRow>& rows);

// The least distance between the centres of the aircraft and any target; between two rows both move evenly.
struct Closest {
  double distance_m = std::numeric_limits<double>::infinity(), t_s = 0;
  std::size_t target = 0;
  Eigen::Vector3d target_N = Eigen::Vector3d::Zero();  // where that was
};
Closest ClosestOf(const std::vector<records::LogRow>& rows);

std::vector<mission::TelemetryColumn> AvoidColumns();

// How others were met, by the truth; centres of both. Only of flights of the mission "avoid" with targets. The
// line of the course goes from the place at the beginning along the heading that the autopilot had there.
std::vector<mission::Metric> AvoidMetrics();
void AddAvoidMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
