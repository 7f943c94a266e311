// SPDX-License-Identifier: Apache-2.0
#include "control/law/direct/direct_hover.h"

#include <algorithm>
#include <cmath>

#include "base/gravity.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {

RateSetpoint DirectHover(const DirectError& error, const Eigen::Quaterniond& R_NB, const DirectGains& g) {
  Eigen::Vector3d p_N = error.p_N;
  p_N.head<2>() = Limited(p_N.head<2>(), g.offset_limit_m);
  p_N.z() = std::clamp(p_N.z(), -g.offset_limit_m, g.offset_limit_m);
  Eigen::Vector3d a_N = -g.position_per_s2 * p_N - g.velocity_per_s * error.v_N - error.d_N;
  a_N.head<2>() = Limited(a_N.head<2>(), g.acceleration_limit_m_s2);
  a_N.z() = std::clamp(a_N.z(), -g.acceleration_limit_m_s2, g.acceleration_limit_m_s2);
  const Eigen::Vector3d force_N = a_N - kGravity_m_s2 * Eigen::Vector3d::UnitZ();  // for each kg
  const Eigen::Vector3d down_B = R_NB.conjugate() * -force_N.normalized();         // where z_B is to be
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(down_B);
  const double angle = std::atan2(axis.norm(), down_B.z());
  RateSetpoint setpoint;
  // The turn that brings z_B there and no other: nothing about z.
  if (axis.norm() > 1e-9) setpoint.w_B = g.attitude_per_s * angle * axis.normalized();
  setpoint.w_B.head<2>() = Limited(setpoint.w_B.head<2>(), Radians(g.rate_limit_deg_s));
  const double turn = Radians(g.yaw_rate_limit_deg_s);
  setpoint.w_B.z() = std::clamp(g.yaw_per_s * error.yaw, -turn, turn);
  // While z_B is on its way, what of the thrust is along it already.
  const double along = std::max(0.0, -(R_NB * Eigen::Vector3d::UnitZ()).dot(force_N));
  setpoint.thrust = std::clamp(g.hover_thrust * along / kGravity_m_s2, 0.0, 1.0);
  return setpoint;
}

Eigen::Vector3d ThrustAcceleration(double thrust, const Eigen::Quaterniond& R_NB, const DirectGains& g) {
  const double a = kGravity_m_s2 * thrust / g.hover_thrust;
  return R_NB * Eigen::Vector3d(0, 0, -a) + kGravity_m_s2 * Eigen::Vector3d::UnitZ();
}

}  // namespace kestrel::control
