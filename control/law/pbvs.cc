// SPDX-License-Identifier: Apache-2.0
#include "control/law/pbvs.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {

Twist PbvsTwist(const Pose& X_DC, double lambda_per_s) {
  return {-lambda_per_s * (X_DC.R.conjugate() * X_DC.p), -lambda_per_s * LogRotation(X_DC.R)};  // eq. (5.13)
}

Twist PbvsTargetTwist(const Pose& X_CO, const Pose& X_DO, double lambda_per_s) {
  const Eigen::Vector3d theta_u = LogRotation(X_DO.R * X_CO.R.conjugate());                     // of R_DC
  return {-lambda_per_s * (X_DO.p - X_CO.p + X_CO.p.cross(theta_u)), -lambda_per_s * theta_u};  // eq. (5.11)
}

Eigen::Matrix3d RotationVectorInteraction(const Eigen::Vector3d& theta_u) {
  const double theta = theta_u.norm(), half = theta / 2;
  // (1 - sinc(theta) / sinc^2(theta / 2)) / theta^2, by its series where the difference would lose digits
  const double k =
      theta < 1e-2 ? 1.0 / 12 + theta * theta / 720 : (1 - half / std::tan(half)) / (theta * theta);
  const Eigen::Matrix3d K = Skew(theta_u);
  return Eigen::Matrix3d::Identity() + K / 2 + k * K * K;  // eq. (5.9)
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

}  // namespace kestrel::control
