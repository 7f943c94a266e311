// SPDX-License-Identifier: Apache-2.0
#include "control/pbvs.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel {

Twist PbvsTwist(const Pose& X_DC, double lambda_per_s) {
  return {-lambda_per_s * (X_DC.R.conjugate() * X_DC.p), -lambda_per_s * LogRotation(X_DC.R)};  // eq. (5.13)
}

VelocitySetpoint ServoSetpoint(const Pose& X_DH, const ServoGains& gains) {
  const Twist unit = PbvsTwist(X_DH, 1);
  VelocitySetpoint setpoint;
  setpoint.v_H.head<2>() = gains.lambda_per_s * unit.v.head<2>();
  const double speed = setpoint.v_H.head<2>().norm();
  if (speed > gains.speed_limit_m_s) setpoint.v_H.head<2>() *= gains.speed_limit_m_s / speed;
  setpoint.v_H.z() =
      std::clamp(gains.lambda_vertical_per_s * unit.v.z(), -gains.climb_limit_m_s, gains.climb_limit_m_s);
  const double limit = Radians(gains.yaw_rate_limit_deg_s);
  setpoint.yaw_rate = std::clamp(gains.lambda_yaw_per_s * unit.w.z(), -limit, limit);
  return setpoint;
}

}  // namespace kestrel
