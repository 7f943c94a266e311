// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "control/autopilot.h"
#include "control/wire/mavlink_dialects.h"

// Setpoints as PX4 and ArduPilot (Copter) understand them: their frames, masks and what they refuse. Sources:
// PX4's MavlinkReceiver, ArduPilot's GCS_MAVLink_Copter (Copter 4.6) and its page on guided mode.
namespace kestrel::sim {

// What a message asked for. Where its frame turns with the aircraft, or it is to keep or reach a heading, the
// setpoint depends on the aircraft's state at the time.
class MavlinkSetpoint {
 public:
  // now: the aircraft's state when the message came. None: the stack refuses it, or it is of a kind that the
  // emulation cannot fly: accelerations, body rates, a position with a yaw rate, one axis without the others.
  static std::optional<MavlinkSetpoint> Read(const control::wire::mavlink::SetPositionTargetLocalNed& message,
                                             const control::VehicleState& now,
                                             const control::wire::mavlink::Dialect& dialect);
  static std::optional<MavlinkSetpoint> Read(const control::wire::mavlink::SetAttitudeTarget& message,
                                             const control::wire::mavlink::Dialect& dialect);

  control::Setpoint At(const control::VehicleState& now) const;
  bool IsPosition() const { return std::holds_alternative<control::PositionSetpoint>(setpoint_); }

 private:
  control::Setpoint setpoint_;
  std::optional<Eigen::Vector3d> v_N_;  // of a velocity that was given in N
  std::optional<double> yaw_;           // to be turned to, besides the setpoint's yaw rate
};

}  // namespace kestrel::sim
