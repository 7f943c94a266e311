// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "mission/decision.h"
#include "mission/path/waypoint_path.h"

namespace kestrel::mission {

// What missions along a path report of each frame, beside their own.
struct PathReport : MissionReport {
  std::optional<WaypointPath::Reference> reference;  // when the decision was made; none: not on the path yet
};

// Flies a path by the autopilot's own state: takes off if the aircraft stands, and lays the path from where it
// is in the air.
class PathPilot {
 public:
  // From the place and the yaw of the aircraft, by its autopilot, the path that begins there.
  using Plan = std::function<std::vector<Waypoint>(const Eigen::Vector3d& p_N, double yaw)>;

  // height_m: above the autopilot's local origin, of the take-off.
  PathPilot(double height_m, const PathParameters& parameters, Plan plan)
      : height_m_(height_m), parameters_(parameters), plan_(std::move(plan)) {}

  // Sets phase and setpoint, and returns the reference that they are for.
  std::optional<WaypointPath::Reference> Fly(const control::VehicleState& state, Decision& decision);

  double path_s(const control::VehicleState& state) const { return path_ ? state.t_s - begun_s_ : 0; }
  // Empty until the path is laid.
  const std::optional<WaypointPath>& path() const { return path_; }
  bool AtEnd(const control::VehicleState& state) const {
    return path_ && path_s(state) >= path_->duration_s();
  }

 private:
  double height_m_;
  PathParameters parameters_;
  Plan plan_;
  std::optional<WaypointPath> path_;
  std::optional<control::PositionSetpoint> take_off_;
  double begun_s_ = 0;
};

}  // namespace kestrel::mission
