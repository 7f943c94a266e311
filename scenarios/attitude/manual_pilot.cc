// SPDX-License-Identifier: Apache-2.0
#include "scenarios/attitude/manual_pilot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/gravity.h"
#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Towards home, and against the speed.
constexpr double kHome_per_s2 = 0.15, kSpeed_per_s = 0.55, kMaxCare_m_s2 = 2.5;
constexpr double kHeight_per_s2 = 1.0, kClimb_per_s = 1.6, kLearn_per_m_s = 0.02;

}  // namespace

double ManualPilot::Swing::At(double t_s) const { return std::sin(rate * t_s + phase); }

ManualPilot::ManualPilot(const ManoeuvreParameters& manoeuvres, std::uint64_t seed) : p_(manoeuvres) {
  RandomStream random(seed, "manual pilot");
  const auto swing = [&](double period_s) {
    return Swing{kTurn / (period_s * random.Uniform(0.85, 1.2)), random.Uniform(0, kTurn)};
  };
  for (auto* axis : {&roll_, &pitch_})
    *axis = {swing(p_.period_s), swing(0.62 * p_.period_s), swing(17), swing(11)};
  yaw_ = swing(p_.yaw_period_s);
  climb_ = swing(60);
}

control::AttitudeSetpoint ManualPilot::Fly(const control::VehicleState& state,
                                           const Eigen::Vector3d& home_N) {
  const double t = state.t_s, dt = last_s_ < 0 ? 0 : std::clamp(t - last_s_, 0.0, 0.2);
  last_s_ = t;
  const auto swing = [&](const std::array<Swing, 4>& axis) {
    const double strength = 0.65 + 0.35 * axis[2].At(t);
    return Radians(p_.tilt_deg) * strength * (0.75 * axis[0].At(t) + 0.35 * axis[1].At(t) * axis[3].At(t));
  };
  const double yaw = YawOf(state.R_NB);
  Eigen::Vector2d care_N =
      kHome_per_s2 * (home_N - state.p_NB).head<2>() - kSpeed_per_s * state.v_N.head<2>();
  care_N *= std::min(1.0, kMaxCare_m_s2 / std::max(care_N.norm(), 1e-9));
  const Eigen::Vector2d care_H = Eigen::Rotation2Dd(-yaw) * care_N;
  const double most = Radians(p_.tilt_deg);
  control::AttitudeSetpoint stick;
  stick.roll = std::clamp(swing(roll_) + std::atan(care_H.y() / kGravity_m_s2), -most, most);
  stick.pitch = std::clamp(swing(pitch_) - std::atan(care_H.x() / kGravity_m_s2), -most, most);
  stick.yaw_rate = Radians(p_.yaw_rate_deg_s * yaw_.At(t) + p_.net_turn_deg_s);

  const double wanted_m = p_.height_m + p_.height_swing_m * climb_.At(t);
  const double low_by = state.p_NB.z() - home_N.z() + wanted_m;
  hover_thrust_ = std::clamp(hover_thrust_ + kLearn_per_m_s * std::clamp(low_by, -2.0, 2.0) * dt, 0.3, 0.8);
  const double climb = std::clamp(kHeight_per_s2 * low_by, -3.0, 3.0) + kClimb_per_s * state.v_N.z();
  const double upright = (state.R_NB * Eigen::Vector3d::UnitZ()).z();
  stick.thrust = std::clamp(hover_thrust_ * (1 + climb / kGravity_m_s2) / std::max(upright, 0.6), 0.1, 1.0);
  return stick;
}

}  // namespace kestrel::scenarios
