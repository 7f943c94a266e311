// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "control/law/level/level_servo.h"
#include "control/law/point_servo.h"
#include "geometry/pose.h"

namespace kestrel::mission {

// The values of flight.law.
const std::vector<std::string>& ServoLawNames();

// What a law is given: V is the camera that the aircraft would have if it were level, or the camera itself
// where nothing is levelled; D is that camera at the goal. The corners are of the pad, in order around it.
struct ServoView {
  std::vector<control::ImagePoint> corners, corners_wanted;  // with the depths that the pose has
  control::ImagePoint centre, centre_wanted;
  Pose X_VT, X_DT;
  Eigen::Vector3d down_V = Eigen::Vector3d::UnitZ();
  std::optional<double> plane_depth_m;  // the adaptive estimate, of a law that goes by it
};

struct ServoAnswer {
  control::LevelTwist twist;
  control::ServoState state = control::ServoState::kRegular;
  double conditioning = 1, reach = 1;  // of laws that invert a matrix (control/law/servo_law.h)
};

// law: one of the names.
ServoAnswer AnswerOf(const std::string& law, const ServoView& view, double lambda_per_s);

}  // namespace kestrel::mission
