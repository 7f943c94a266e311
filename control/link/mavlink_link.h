// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "control/link/autopilot_link.h"
#include "control/link/mavlink_session.h"

namespace kestrel::control {

// PX4 or ArduPilot (Copter) by MAVLink 2 over UDP, or over TCP as its client; which of them, its heartbeat tells. MAVLink is used
// without signatures here: whoever reaches the port may pretend to be the autopilot.
//
// Listening, it answers to the address from which an autopilot's heartbeat comes first, and takes nothing
// from any other until that one has been silent for MavlinkSession::kSilent_s. Sending to an address, it
// takes nothing but what comes from there. By TCP it connects to a server, such as ArduPilot's SITL, and again whenever
// that refuses it or leaves (tcp_client.h); LinkHealth::error says so meanwhile, and the session goes on as after any
// silence.
//
// LinkHealth::pilot_allows: setpoints are followed, or take_control is on and will ask for that. Once the
// mode in which they are followed was left, by the pilot or by the autopilot's own fail-safe, it is not asked
// for again until TakeControl(): the pilot is not overruled. With a switch_channel, his switch must allow it
// too.
//
// A position above the ground on which it stands is the command to take off: with `arm` it arms the motors
// for that, in the mode for setpoints alone. ArduPilot is told to take off, and sent no setpoint until it
// has.
//
// State::t_s by TIMESYNC, right within half a round trip, where it is answered; if not, by ClockSync.
class MavlinkLink final : public AutopilotLink {
 public:
  // Throws InputError if the address cannot be understood or listened on.
  MavlinkLink(const std::string& address, const MavlinkOptions& options);
  ~MavlinkLink() override;

  VehicleState State() const override;
  void Send(const Setpoint& setpoint) override;
  // Nothing: MAVLink tells an attitude from a camera only together with a position
  // (VISION_POSITION_ESTIMATE), which would be made up. It is an error by name.
  void Aid(const AttitudeAid& aid) override;
  LinkHealth Health() const override;
  void Silence() override;
  // As MavlinkOptions::landing_target and vision_position say, once for each sighting.
  void See(const Sighting& sighting) override;

  void TakeControl();  // the mode for setpoints is asked for, once they are streaming
  // Where it listens, sends or is connected to: as control/link/network_address.h reads it.
  std::string Where() const;

 private:
  struct Wire;
  std::unique_ptr<Wire> wire_;
};

}  // namespace kestrel::control
