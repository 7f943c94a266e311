// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/pose.h"

namespace kestrel {

// Another thing in the air.
struct TargetTruth {
  double diameter_m = 0;
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // of its centre
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_V =
      Eigen::Vector3d::Zero();  // LevelAhead of the camera (control/estimate/moving_target.h)
  bool in_view = false;         // its centre is in the image
};

// What the simulator knows and no flight code may see: for records, criteria and tests.
struct Truth {
  double t_s = 0;
  Pose X_NB;                                         // the aircraft
  Pose X_NC;                                         // its camera, shaken as its mount is
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();     // m/s
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();     // rad/s
  Eigen::Vector3d wind_N = Eigen::Vector3d::Zero();  // velocity of the air at the aircraft, m/s
  Pose X_NT;  // the pad: x along its long side, z down, origin at its centre
  Eigen::Vector3d v_NT = Eigen::Vector3d::Zero();  // m/s, of its centre, in N
  Eigen::Vector3d w_NT = Eigen::Vector3d::Zero();  // rad/s, in N
  bool touching = false;                           // the skids touch something
  bool attitude_failed = false;                    // a fault of the autopilot's own attitude is on
  std::vector<TargetTruth> targets;
};

}  // namespace kestrel
