// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "records/telemetry/flight_log.h"

namespace kestrel::mission {
struct MissionType;
}

namespace kestrel::records {

// Those of every mission, as listed below.
std::vector<std::string> CommonMetricNames();
// Every metric that a run of any mission may have, for checking the names of criteria.
std::vector<std::string> MetricNames();

// Whether a metric is of what the flight code saw or wanted: without its decisions it cannot be had.
bool NeedsDecisions(const std::string& metric);

// What a flight did, judged by the truth alone. touch: the instant before the first touch-down. Metrics that
// do not apply (no fix, no goal, no landing) are not there.
//   fix_{x,y,z}_rmse_m, fix_yaw_rmse_deg  camera fix less truth in the pad's frame, at the exposures
//   fix_share                             share of the frames with a fix
//   longest_loss_s                        longest time without one, from the first fix on
//   settle_s                              first time from which the flight stayed within 0.15 m of its goal
//   for 3 s hold_horizontal_rmse_m, hold_vertical_rmse_m, hold_yaw_rmse_deg
//                                         distance from the goal from 15 s on
//   touchdown_error_m, touchdown_sink_m_s, touchdown_tilt_deg, touchdown_speed_m_s, touchdown_s
//                                         at the first touch: from the pad's centre, downwards, from level,
//                                         sideways
//   touchdown_north_m, touchdown_east_m   the same instant: from the pad's centre, in N
//   rest_error_m, rest_tilt_deg           at the end of a landing
//   greatest_tilt_deg                     of the flight
//   failure_attitude_rms_deg              while the autopilot's own attitude has failed: "down" as it is
//                                         flown by, from the truth
//   failure_tilt_rms_deg                  the same time: from level, lean against the wind and all
//   failure_heading_worst_deg, failure_height_worst_m, failure_place_worst_m
//                                         the same time: farthest from where the aircraft was at its
//                                         beginning
//   failure_noticed_s                     until the autopilot flew by another attitude for the first time
//   failure_returned                      1: that was so, and at the end of the flight it flew by its own
//                                         again
// and those that the type of the mission declares; null: of a flight whose mission is not known.
std::map<std::string, double> Metrics(const std::vector<LogRow>& rows, const std::optional<Truth>& touch,
                                      const mission::MissionType* type);

}  // namespace kestrel::records
