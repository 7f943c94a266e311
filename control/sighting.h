// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace kestrel::control {

// Where an aircraft is by what its camera saw of a target, for an autopilot that flies by it. T is the target's own
// frame: origin at its centre, z down.
struct Sighting {
  double t_s = 0;                                  // of the exposure, on the monotonic clock of this computer
  Eigen::Vector3d p_TB = Eigen::Vector3d::Zero();  // m
  Eigen::Quaterniond R_TB = Eigen::Quaterniond::Identity();
  // Of p_TB, m, and of a rotation vector in T, rad. Its first element NaN: unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace kestrel::control
