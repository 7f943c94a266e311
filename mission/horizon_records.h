// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/horizon_observer.h"
#include "mission/mission_type.h"

// What missions whose report is a HorizonReport declare.
namespace kestrel::mission {

std::vector<TelemetryColumn> HorizonColumns();

//   roll_rmse_deg, pitch_rmse_deg         of the attitude that images gave, at their exposures
//   attitude_share, attitude_outliers     share of the frames with one; how many were wrong by over 5 degrees
//   attitude_within_2_sigma               share of rolls and pitches no farther off than they state
//   yaw_rmse_deg, yaw_rmse_first_half_deg, yaw_rmse_second_half_deg
//                                         of the heading since the first image that had one
//   baseline_...                          the same of the reference method
std::vector<std::string> HorizonMetricNames();
void AddHorizonMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::mission
