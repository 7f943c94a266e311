// SPDX-License-Identifier: Apache-2.0
#include "control/law/velocity_loop.h"

#include <algorithm>
#include <cmath>

#include "base/gravity.h"
#include "control/law/level_acceleration.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kPause_s = 0.5;
constexpr double kIntegralLimit_m_s2 = 0.6 * kGravity_m_s2;

constexpr double kTouchDescent_m_s = 0.12;
constexpr double kTouchStill_m_s = 0.09;
constexpr double kTouchTime_s = 0.8;
constexpr double kTouchSpool_s = 0.4;
constexpr double kTouchFalling_m_s = 0.35;
constexpr double kTouchThrottle = 0.4;

}  // namespace

VelocityLoopOutput StepVelocityLoop(const VelocitySetpoint& wanted, const VehicleState& vehicle,
                                    const VelocityLoopState& before, const VelocityLoopOptions& o) {
  VelocityLoopOutput out;
  VelocityLoopState& state = out.state = before;
  double dt_s = before.t_s ? vehicle.t_s - *before.t_s : kPause_s;
  if (!(dt_s >= 0 && dt_s < kPause_s)) dt_s = 0, state.command_N = state.reference_N = vehicle.v_N;
  state.t_s = vehicle.t_s;

  const double yaw = YawOf(vehicle.R_NB);
  Eigen::Vector3d v_N = HeadingRotation(yaw) * wanted.v_H;
  v_N.head<2>() = Limited(v_N.head<2>(), o.speed_limit_m_s);
  v_N.z() = std::clamp(v_N.z(), -o.climb_limit_m_s, o.climb_limit_m_s);
  Eigen::Vector3d step = v_N - state.command_N;
  const double most = o.acceleration_limit_m_s2 * dt_s;
  step.head<2>() = Limited(step.head<2>(), most);
  step.z() = std::clamp(step.z(), -most, most);
  state.command_N += step;

  const Eigen::Vector3d delay_s(o.level_delay_s, o.level_delay_s, o.climb_delay_s);
  const Eigen::Vector3d nearer = (dt_s / (delay_s.array() + dt_s + 1e-9)).matrix();
  state.reference_N += nearer.cwiseProduct(state.command_N - state.reference_N);

  const Eigen::Vector3d error = state.reference_N - vehicle.v_N;
  const Eigen::Vector3d gain(o.velocity_gain_per_s, o.velocity_gain_per_s, o.climb_gain_per_s);
  Eigen::Vector3d a_N = state.integral_N + gain.cwiseProduct(error);
  if (dt_s > 0) a_N += step / dt_s;

  const LevelTilt tilt = TiltToAccelerate(a_N.head<2>(), yaw, Radians(o.tilt_limit_deg));
  out.setpoint.pitch = tilt.pitch / o.pitch_gain;
  out.setpoint.roll = tilt.roll / o.roll_gain;

  const double upright = std::max(0.5, (vehicle.R_NB * Eigen::Vector3d::UnitZ()).z());
  const double thrust = o.hover_thrust * (kGravity_m_s2 - a_N.z()) / kGravity_m_s2 / upright;
  // An upper limit below the lower one is nonsense that must not become undefined behaviour.
  out.setpoint.thrust = std::clamp(thrust, o.thrust_min, std::max(o.thrust_min, o.thrust_max));

  // Against a limit an integral goes only where it leads away from it, so that nothing has to be unwound.
  const Eigen::Vector3d integral =
      Eigen::Vector3d(o.velocity_integral_per_s2, o.velocity_integral_per_s2, o.climb_integral_per_s2)
          .cwiseProduct(error) *
      dt_s;
  if (!tilt.limited || integral.head<2>().dot(tilt.acceleration_N) < 0)
    state.integral_N.head<2>() += integral.head<2>();
  const double beyond = thrust - out.setpoint.thrust;  // more thrust is a smaller a_z
  if (beyond * integral.z() >= 0) state.integral_N.z() += integral.z();
  state.integral_N.head<2>() = Limited(state.integral_N.head<2>(), kIntegralLimit_m_s2);
  state.integral_N.z() = std::clamp(state.integral_N.z(), -kIntegralLimit_m_s2, kIntegralLimit_m_s2);

  const double turn = Radians(o.yaw_rate_limit_deg_s);
  out.setpoint.yaw_rate = std::clamp(wanted.yaw_rate, -turn, turn);
  out.limited = tilt.limited || beyond != 0;
  return out;
}

VelocitySetpoint VelocityToward(const PositionSetpoint& wanted, const VehicleState& vehicle,
                                const VelocityLoopOptions& o) {
  const double yaw = YawOf(vehicle.R_NB), turn = Radians(o.yaw_rate_limit_deg_s);
  Eigen::Vector3d v_N = o.position_gain_per_s * (wanted.p_N - vehicle.p_NB);
  v_N.head<2>() = Limited(v_N.head<2>(), o.speed_limit_m_s);
  v_N.z() = std::clamp(v_N.z(), -o.climb_limit_m_s, o.climb_limit_m_s);
  return {HeadingRotation(-yaw) * v_N,
          std::clamp(o.yaw_gain_per_s * WrapAngle(wanted.yaw - yaw), -turn, turn)};
}

TouchDown WatchTouchDown(double dt_s, double asked_m_s, double sinking_m_s, const TouchDown& before) {
  if (before.down) return before;
  if (asked_m_s <= kTouchDescent_m_s || sinking_m_s > kTouchFalling_m_s) return {};
  TouchDown now = before;
  if (now.throttle >= 1) {
    now.still_s = std::max(0.0, now.still_s + (sinking_m_s < kTouchStill_m_s ? dt_s : -2 * dt_s));
    if (now.still_s < kTouchTime_s) return now;
  }
  now.throttle -= dt_s / kTouchSpool_s;
  now.down = now.throttle < kTouchThrottle;
  return now;
}

}  // namespace kestrel::control
