// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"
#include "control/autopilot.h"

namespace kestrel::mission {

// A place to be at, and for how long.
struct Waypoint {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // m
  double yaw = 0;          // rad, of any number of turns: from 0 to 2 pi is a whole turn
  double hold_s = 0;       // stays there once it has arrived
  std::string_view phase;  // of the flight plan, on the way there and while it stays
};

// How a path is flown by the autopilot's own state.
struct PathParameters {
  double speed_m_s = 2, acceleration_m_s2 = 0.5;
  double yaw_rate_deg_s = 15, yaw_acceleration_deg_s2 = 10;
  double lambda_per_s = 0.6;
};

inline void Fields(FieldVisitor& v, PathParameters& p) {
  v({"speed_m_s", "speed along the legs of the path"}, p.speed_m_s, 0.05, 20.0);
  v({"acceleration_m_s2", "acceleration at the beginning and the end of each leg"}, p.acceleration_m_s2, 0.05,
    5.0);
  v({"yaw_rate_deg_s", "yaw rate of turns"}, p.yaw_rate_deg_s, 0.5, 90.0);
  v({"yaw_acceleration_deg_s2", "angular acceleration at the beginning and the end of each turn"},
    p.yaw_acceleration_deg_s2, 0.5, 180.0);
  v({"lambda_per_s", "proportional gain from the error of position and yaw to velocity and yaw rate"},
    p.lambda_per_s, 0.0, 3.0);
}

// From waypoint to waypoint in straight legs, from rest to rest: place and yaw in step, with velocities that are
// trapezoids over time. A function of the time since its beginning alone.
class WaypointPath {
 public:
  // Begins at the first; at least one.
  WaypointPath(std::vector<Waypoint> waypoints, const PathParameters& parameters);

  struct Reference {  // where the aircraft is meant to be
    Eigen::Vector3d p_N = Eigen::Vector3d::Zero(), v_N = Eigen::Vector3d::Zero();
    double yaw = 0, yaw_rate = 0;
    std::size_t waypoint = 0;  // on the way to it, or there
  };
  Reference At(double t_s) const;  // before 0 as at 0, after the end as there
  double arrival_s(std::size_t waypoint) const { return arrival_s_[waypoint]; }
  double duration_s() const;  // with the time of staying at the last
  const std::vector<Waypoint>& waypoints() const { return waypoints_; }

 private:
  struct Leg {
    double ramp_s = 0, cruise_s = 0;  // a trapezoid: ramp, cruise, ramp; as a share of the leg its area is 1
  };
  std::vector<Waypoint> waypoints_;
  std::vector<Leg> legs_;  // to each waypoint; the first is of no length
  std::vector<double> arrival_s_;
};

// The velocity towards a reference: its own, and lambda times the error. Its sum is within twice the speed, the
// climb and the yaw rate of the parameters.
control::VelocitySetpoint FollowPath(const WaypointPath::Reference& reference,
                                     const control::VehicleState& state, const PathParameters& parameters);

}  // namespace kestrel::mission
