// SPDX-License-Identifier: Apache-2.0
#include "mission/pilot.h"

#include "geometry/tait_bryan.h"

namespace kestrel::mission {

void Pilot::Hear(const control::VehicleState& state) {
  yaw_NB_ = YawOf(state.R_NB);
  following_.Hear(state);
}

Eigen::Vector3d Pilot::Ahead_T() const {
  const control::TargetEstimator::Estimate& estimate = where();
  return estimate.p_TB + HeadingRotation(estimate.yaw_TB - yaw_NB_) * following_.ToCome_N();
}

void Pilot::Give(const control::VelocitySetpoint& setpoint) {
  const control::TargetEstimator::Estimate& estimate = where();
  const Eigen::Vector3d asked_N = HeadingRotation(yaw_NB_) * setpoint.v_H;
  following_.Give(asked_N, asked_N - HeadingRotation(yaw_NB_ - estimate.yaw_TB) * estimate.velocity_error_T);
}

control::VelocitySetpoint Pilot::GoTo(const Eigen::Vector3d& p_T, double yaw_T) {
  const control::TargetEstimator::Estimate& estimate = where();
  const Pose X_TH{HeadingRotation(estimate.yaw_TB), Ahead_T()};
  const Pose X_TD{HeadingRotation(yaw_T), p_T};
  control::VelocitySetpoint setpoint = control::ServoSetpoint(X_TD.Inverse() * X_TH, servo_);
  // The autopilot flies the velocity that it believes in: ask for what is wanted plus its error.
  setpoint.v_H += X_TH.R.conjugate() * estimate.velocity_error_T;
  Give(setpoint);
  return setpoint;
}

control::VelocitySetpoint Pilot::DescendTo(const Eigen::Vector2d& p_T, double yaw_T, double sink_m_s) {
  control::VelocitySetpoint setpoint = GoTo({p_T.x(), p_T.y(), Ahead_T().z()}, yaw_T);
  setpoint.v_H.z() += sink_m_s;
  Give(setpoint);
  return setpoint;
}

control::VelocityLag Pilot::MaxLag() const {
  return {kestrel::control::MaxLag(servo_.lambda_per_s),
          kestrel::control::MaxLag(servo_.lambda_vertical_per_s)};
}

}  // namespace kestrel::mission
