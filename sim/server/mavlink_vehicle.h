// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/wire/mavlink_dialects.h"
#include "sim/server/geodetic_origin.h"
#include "sim/server/mavlink_setpoints.h"
#include "sim/server/wire_counts.h"

namespace kestrel::sim {

struct MavlinkServerOptions {
  std::string dialect = "px4";  // or "ardupilot"
  std::string listen = "127.0.0.1";
  int port = 14580;  // 0: the system chooses
  // Told without being asked, as PX4 tells 127.0.0.1:14540 and a ground station is told on 14550:
  // "udp://HOST:PORT"; empty: whoever opens the session is told.
  std::string peer = "";
  int system = 1, component = 1;
  int type = 2;  // MAV_TYPE: 2 a quadrotor, 4 a helicopter
  GeodeticOrigin origin = {};
  int switch_channel = 7;  // of the pilot's transmitter, as told in RC_CHANNELS
};

inline void Fields(FieldVisitor& v, MavlinkServerOptions& o) {
  v({"dialect", "which autopilot's modes and habits are emulated"}, o.dialect, {"px4", "ardupilot"});
  v({"listen", "address to listen on"}, o.listen);
  v({"port", "UDP port to listen on; 0: any that is free"}, o.port, 0, 65535);
  v({"peer", "udp://HOST:PORT that is sent to without being asked; empty: whoever opens the session"},
    o.peer);
  v({"system", "MAVLink system id of the vehicle"}, o.system, 1, 255);
  v({"component", "MAVLink component id of the autopilot"}, o.component, 1, 255);
  v({"type", "MAV_TYPE of the vehicle: 2 a quadrotor, 4 a helicopter"}, o.type, 0, 255);
  v({"origin", "where the origin of N is on the earth"}, o.origin);
  v({"switch_channel", "channel of RC_CHANNELS that tells the pilot's switch"}, o.switch_channel, 1, 18);
}

// What PX4 or ArduPilot says and heeds on behalf of an emulated autopilot, without a socket: datagrams and
// times in, datagrams out. now_s is any clock that runs in real time.
//
// Emulated of both: heartbeats; ATTITUDE, ATTITUDE_QUATERNION, LOCAL_POSITION_NED, GLOBAL_POSITION_INT,
// EXTENDED_SYS_STATE, RC_CHANNELS (the pilot's switch) and SYSTEM_TIME, at rates that SET_MESSAGE_INTERVAL
// changes; TIMESYNC; arming and disarming on the ground, disarming after touch-down and where no take-off
// follows; modes for setpoints, for holding the place and for landing; TAKEOFF. Of setpoints what
// sim/server/mavlink_setpoints.h says. Of PX4: OFFBOARD needs setpoints for a second before, and is left for
// holding the place when they stop for its time-out. Of ArduPilot: GUIDED is kept, but the aircraft stops
// when velocities or attitudes stop for its time-out, or are malformed; on the ground setpoints do nothing.
// ArduPilot streams nothing before it is asked to, PX4 the messages above: that and the rates are assumed.
//
// Parameters, missions, other commands: answered as unsupported, or not at all.
class MavlinkVehicle {
 public:
  explicit MavlinkVehicle(const MavlinkServerOptions& options);

  // Whether it holds a heartbeat of a companion or a ground station.
  bool OpensSession(std::span<const std::uint8_t> datagram) const;
  void Greet() { next_heartbeat_s_ = std::numeric_limits<double>::lowest(); }  // its heartbeat is due
  void Receive(std::span<const std::uint8_t> datagram, double now_s, control::Autopilot& aircraft);
  std::vector<control::wire::Bytes> Due(double now_s, control::Autopilot& aircraft);
  // To a client that is not taken: a STATUSTEXT.
  control::wire::Bytes Refusal();
  WireCounts& received() { return counts_; }
  const WireCounts& received() const { return counts_; }
  // Turned off, the aircraft is in the pilot's own mode and no other can be had; turned on, it is put into
  // the mode for setpoints, if the dialect lets him.
  void SetPilot(bool allows);

 private:
  struct Stream {
    double period_s = 0;  // 0: none
    double default_s = 0;
    double next_s = 0;
  };

  void Handle(const control::wire::mavlink::Message& message, double now_s, control::Autopilot& aircraft);
  void Command(const control::wire::mavlink::CommandLong& command, double now_s,
               control::Autopilot& aircraft);
  std::uint8_t SetMode(std::uint32_t custom_mode, double now_s);
  std::uint8_t Arm(bool armed, double now_s, const control::VehicleState& state);
  std::uint8_t TakeOff(double param7, control::Autopilot& aircraft);
  std::uint8_t SetInterval(const control::wire::mavlink::CommandLong& command, double now_s);
  // message: what it was read from.
  void TakeSetpoint(const std::optional<MavlinkSetpoint>& setpoint,
                    const control::wire::mavlink::Message& message, double now_s,
                    control::Autopilot& aircraft);
  void Follow(double now_s, control::Autopilot& aircraft);
  void Stop(control::Autopilot& aircraft);
  bool ForMe(std::uint8_t system, std::uint8_t component) const;
  void Warn(const std::string& text);
  control::wire::mavlink::Message Of(std::uint32_t id, const control::VehicleState& state) const;
  void Say(const control::wire::mavlink::Message& message);

  MavlinkServerOptions options_;
  const control::wire::mavlink::Dialect& dialect_;
  control::wire::mavlink::Parser parser_;
  control::wire::mavlink::Sender sender_, to_others_;
  WireCounts counts_;
  std::vector<control::wire::Bytes> out_;
  std::map<std::uint32_t, Stream> streams_;
  double next_heartbeat_s_ = 0;

  std::uint32_t mode_;
  bool armed_ = false;
  double armed_s_ = 0;
  bool flew_ = false;  // since it was armed
  bool begun_ = false;

  std::optional<MavlinkSetpoint> setpoint_;
  double setpoint_s_ = 0;              // when the last came
  std::optional<double> streaming_s_;  // since when they have been coming

  bool pilot_allows_ = true, pilot_was_ = true;
};

}  // namespace kestrel::sim
