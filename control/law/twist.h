// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::control {

// Velocity of a frame C, expressed in C: m/s and rad/s. As a vector of six: (v, w).
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
};

}  // namespace kestrel::control
