// SPDX-License-Identifier: Apache-2.0
#include "control/law/level_acceleration.h"

#include <cmath>

#include "base/gravity.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {

LevelTilt TiltToAccelerate(const Eigen::Vector2d& a_N, double yaw, double tilt_limit) {
  LevelTilt tilt;
  tilt.acceleration_N = Limited(a_N, kGravity_m_s2 * std::tan(tilt_limit));
  tilt.limited = tilt.acceleration_N.norm() < a_N.norm() - 1e-9;
  const Eigen::Vector3d a_H =
      HeadingRotation(-yaw) * Eigen::Vector3d(tilt.acceleration_N.x(), tilt.acceleration_N.y(), 0);
  tilt.pitch = -std::atan2(a_H.x(), kGravity_m_s2);
  tilt.roll = std::atan2(a_H.y() * std::cos(tilt.pitch), kGravity_m_s2);
  return tilt;
}

}  // namespace kestrel::control
