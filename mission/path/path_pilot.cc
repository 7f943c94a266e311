// SPDX-License-Identifier: Apache-2.0
#include "mission/path/path_pilot.h"

#include "geometry/tait_bryan.h"

namespace kestrel::mission {

std::optional<WaypointPath::Reference> PathPilot::Fly(const control::VehicleState& state,
                                                      Decision& decision) {
  const bool rises = state.landed || state.mode == control::FlightMode::kTakeOff;
  if (rises) {
    if (!take_off_)
      take_off_ = control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -height_m_}, YawOf(state.R_NB)};
    path_.reset();
    decision.phase = "take off";
    decision.setpoint = *take_off_;
    return std::nullopt;
  }
  if (!path_) {
    path_.emplace(plan_(state.p_NB, YawOf(state.R_NB)), parameters_);
    begun_s_ = state.t_s;
  }
  const WaypointPath::Reference reference = path_->At(path_s(state));
  decision.phase = path_->waypoints()[reference.waypoint].phase;
  decision.setpoint = FollowPath(reference, state, parameters_);
  return reference;
}

}  // namespace kestrel::mission
