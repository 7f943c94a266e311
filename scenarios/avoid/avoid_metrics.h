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
std::vector<std::string> AvoidMetricNames();

// How others were met, by the truth; centres of both. Only of flights of the mission "avoid" with targets.
//   closest_m            least distance to any target
//   closest_s            when
//   closest_share        of what the thesis's bearing allows past a thing that stands still: the distance
//                        when one was first held at a bearing, times the sine of 50 degrees
//   manoeuvred           1: a bearing was held at all
//   manoeuvre_s          when first
//   manoeuvre_height_m   farthest from the height at the beginning
//   course_end_m         at the end: distance from the line of the course: from the place at the beginning
//                        along the heading that the autopilot had there
//   course_end_own_m     the same by the autopilot's own position, whose drift is no fault of the manoeuvre
//   path_excess          the length of the path over the ground over its straight line, less 1
void AddAvoidMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
