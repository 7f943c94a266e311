// SPDX-License-Identifier: Apache-2.0
#include "mission/path/waypoint_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/limited.h"
#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

// The shortest trapezoid from rest to rest over this length.
struct Trapezoid {
  double ramp_s, cruise_s;
};
Trapezoid Shortest(double length, double speed, double acceleration) {
  const double ramp_s = std::min(speed / acceleration, std::sqrt(length / acceleration));
  return {ramp_s, ramp_s > 0 ? std::max(0.0, length / (acceleration * ramp_s) - ramp_s) : 0};
}

}  // namespace

WaypointPath::WaypointPath(std::vector<Waypoint> waypoints, const PathParameters& p)
    : waypoints_(std::move(waypoints)) {
  assert(!waypoints_.empty());
  double at_s = 0;
  for (std::size_t i = 0; i < waypoints_.size(); ++i) {
    Leg leg;
    if (i > 0) {
      const Waypoint &from = waypoints_[i - 1], &to = waypoints_[i];
      const Trapezoid way = Shortest((to.p_N - from.p_N).norm(), p.speed_m_s, p.acceleration_m_s2);
      const Trapezoid turn = Shortest(std::abs(to.yaw - from.yaw), Radians(p.yaw_rate_deg_s),
                                      Radians(p.yaw_acceleration_deg_s2));
      // In step: the longer ramp and the longer whole serve both.
      leg.ramp_s = std::max(way.ramp_s, turn.ramp_s);
      leg.cruise_s =
          std::max({0.0, way.ramp_s + way.cruise_s - leg.ramp_s, turn.ramp_s + turn.cruise_s - leg.ramp_s});
    }
    at_s += 2 * leg.ramp_s + leg.cruise_s;
    legs_.push_back(leg);
    arrival_s_.push_back(at_s);
    at_s += waypoints_[i].hold_s;
  }
}

double WaypointPath::duration_s() const { return arrival_s_.back() + waypoints_.back().hold_s; }

WaypointPath::Reference WaypointPath::At(double t_s) const {
  std::size_t i = 0;
  while (i + 1 < waypoints_.size() && t_s >= arrival_s_[i] + waypoints_[i].hold_s) ++i;
  const Waypoint &to = waypoints_[i], &from = waypoints_[i > 0 ? i - 1 : 0];
  const Leg& leg = legs_[i];
  const double whole_s = 2 * leg.ramp_s + leg.cruise_s;
  const double t = t_s - (arrival_s_[i] - whole_s);
  double share = 1, rate = 0;  // of the leg, and of it in a second
  if (t < whole_s && whole_s > 0) {
    const double top = 1 / (leg.ramp_s + leg.cruise_s), left = whole_s - t;
    if (t < leg.ramp_s) {
      share = top * t * t / (2 * leg.ramp_s), rate = top * t / leg.ramp_s;
    } else if (left < leg.ramp_s) {
      share = 1 - top * left * left / (2 * leg.ramp_s), rate = top * left / leg.ramp_s;
    } else {
      share = top * (t - leg.ramp_s / 2), rate = top;
    }
  }
  const Eigen::Vector3d way = to.p_N - from.p_N;
  const double turn = to.yaw - from.yaw;
  return {from.p_N + share * way, rate * way, from.yaw + share * turn, rate * turn, i};
}

control::VelocitySetpoint FollowPath(const WaypointPath::Reference& reference,
                                     const control::VehicleState& state, const PathParameters& p) {
  const double yaw = YawOf(state.R_NB), speed = 2 * p.speed_m_s, turn = 2 * Radians(p.yaw_rate_deg_s);
  const Eigen::Vector3d v_N = reference.v_N + p.lambda_per_s * (reference.p_N - state.p_NB);
  control::VelocitySetpoint setpoint;
  setpoint.v_H = HeadingRotation(yaw).conjugate() * v_N;
  setpoint.v_H.head<2>() = Limited(setpoint.v_H.head<2>(), speed);
  setpoint.v_H.z() = std::clamp(setpoint.v_H.z(), -speed, speed);
  setpoint.yaw_rate =
      std::clamp(reference.yaw_rate + p.lambda_per_s * WrapAngle(reference.yaw - yaw), -turn, turn);
  return setpoint;
}

}  // namespace kestrel::mission
