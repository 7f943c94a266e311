// SPDX-License-Identifier: Apache-2.0
#include "mission/pilot.h"

#include "geometry/tait_bryan.h"

namespace kestrel::mission {

control::VelocitySetpoint Pilot::GoTo(const Eigen::Vector3d& p_T, double yaw_T) const {
  const control::TargetEstimator::Estimate& estimate = where();
  const Pose X_TH{HeadingRotation(estimate.yaw_TB), estimate.p_TB};
  const Pose X_TD{HeadingRotation(yaw_T), p_T};
  control::VelocitySetpoint setpoint = control::ServoSetpoint(X_TD.Inverse() * X_TH, servo_);
  // The autopilot flies the velocity that it believes in: ask for what is wanted plus its error.
  setpoint.v_H += X_TH.R.conjugate() * estimate.velocity_error_T;
  return setpoint;
}

control::VelocitySetpoint Pilot::DescendTo(const Eigen::Vector2d& p_T, double yaw_T, double sink_m_s) const {
  control::VelocitySetpoint setpoint = GoTo({p_T.x(), p_T.y(), where().p_TB.z()}, yaw_T);
  setpoint.v_H.z() += sink_m_s;
  return setpoint;
}

control::VelocityLag Pilot::MaxLag() const {
  return {kestrel::control::MaxLag(servo_.lambda_per_s),
          kestrel::control::MaxLag(servo_.lambda_vertical_per_s)};
}

}  // namespace kestrel::mission
