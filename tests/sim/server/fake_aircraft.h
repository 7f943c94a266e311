// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "control/autopilot.h"
#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {

// An autopilot that does at once what it is told, and remembers it. It never holds by itself.
class FakeAircraft final : public control::Autopilot {
 public:
  control::VehicleState State() const override { return state; }
  void Send(const control::Setpoint& setpoint) override {
    sent.push_back(setpoint), sent_at_s = state.t_s;
    const auto* position = std::get_if<control::PositionSetpoint>(&setpoint);
    if (state.mode == control::FlightMode::kStopped) {
      if (position == nullptr || position->p_N.z() > state.p_NB.z() - 0.3) return;
      state.mode = control::FlightMode::kTakeOff, state.landed = false;
    }
    following = setpoint;
  }
  void Aid(const control::AttitudeAid&) override {}

  void Step(double dt_s) {
    state.t_s += dt_s;
    if (state.mode == control::FlightMode::kTakeOff && state.p_NB.z() < -0.3)
      state.mode = control::FlightMode::kPosition;
    if (!following) return Move(dt_s, 0);
    if (const auto* velocity = std::get_if<control::VelocitySetpoint>(&*following)) {
      state.v_N = HeadingRotation(YawOf(state.R_NB)) * velocity->v_H;
      Move(dt_s, velocity->yaw_rate);
      if (state.p_NB.z() >= 0 && velocity->v_H.z() > 0) {
        state.mode = control::FlightMode::kStopped, state.landed = true, state.v_N.setZero();
        following.reset();
      }
    } else if (const auto* position = std::get_if<control::PositionSetpoint>(&*following)) {
      const Eigen::Vector3d way = position->p_N - state.p_NB;
      state.v_N = 2 * way / std::max(1.0, way.norm());
      Move(dt_s, 3 * WrapAngle(position->yaw - YawOf(state.R_NB)));
    } else {
      const auto& attitude = std::get<control::AttitudeSetpoint>(*following);
      const double yaw = YawOf(state.R_NB) + dt_s * attitude.yaw_rate;
      state.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({yaw, attitude.pitch, attitude.roll}));
      state.v_N.setZero();
    }
  }

  control::VehicleState state;
  std::vector<control::Setpoint> sent;
  double sent_at_s = 0;
  std::optional<control::Setpoint> following;

 private:
  void Move(double dt_s, double yaw_rate) {
    state.p_NB += dt_s * state.v_N;
    state.w_B = {0, 0, yaw_rate};
    state.R_NB = HeadingRotation(YawOf(state.R_NB) + dt_s * yaw_rate);
  }
};

inline FakeAircraft Flying(double height_m) {
  FakeAircraft aircraft;
  aircraft.state.p_NB = {0, 0, -height_m};
  aircraft.state.mode = control::FlightMode::kPosition;
  aircraft.state.landed = false;
  aircraft.state.t_s = 50;
  return aircraft;
}

}  // namespace kestrel::sim
