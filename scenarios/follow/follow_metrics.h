// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

std::vector<mission::TelemetryColumn> FollowColumns();
std::vector<std::string> FollowMetricNames();

// How well a balloon, the first target, was followed, by the truth: its image in a level camera beside what
// was wanted of it. None of a flight that never followed one.
//   in_view_share          share of the frames with its centre in the image
//   followed_share         share of the frames in which the mission followed it
//   follow_u_rms_px, follow_v_rms_px
//                          of what was wanted, from 4 s after each change of it on
//   follow_distance_rms    of the distance along the axis, share of that wanted; likewise from 4 s on
//   step_u_settle_s        after a change of u wanted, until it stays within 5 % of the change; the longest
//   step_u_overshoot       the farthest beyond it, share of the change; the worst
//   step_distance_error    after a change of the diameter wanted: mean error of the distance over the second
//                          half of the time until the next change, share of that wanted; the worst
void AddFollowMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
