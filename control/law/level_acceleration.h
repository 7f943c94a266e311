// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::control {

// The tilt by which a rotorcraft that holds its height accelerates over ground.
struct LevelTilt {
  double roll = 0, pitch = 0;      // rad
  Eigen::Vector2d acceleration_N;  // that it gives: north, east, m/s^2
  bool limited = false;            // less than what was asked for
};

// a_N: asked for, north and east. yaw, tilt_limit: rad.
LevelTilt TiltToAccelerate(const Eigen::Vector2d& a_N, double yaw, double tilt_limit);

}  // namespace kestrel::control
