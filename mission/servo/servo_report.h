// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "control/law/servo_law.h"
#include "mission/decision.h"

namespace kestrel::mission {

// What a law had of a frame. Corners in pixels of the camera that the law sees by, which is level or not.
struct ServoReport : MissionReport {
  std::array<Eigen::Vector2d, 4> corners_px, wanted_px;
  double error_px = 0;  // RMS over the corners
  control::ServoState state = control::ServoState::kNoFeatures;
  double conditioning = 0, reach = 0;
  double depth_m = 0;  // of the pad's centre, as the law has it
};

}  // namespace kestrel::mission
