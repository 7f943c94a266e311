// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
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
#include "sim/server/mavlink/mavlink_flight.h"
#include "sim/server/mavlink/mavlink_parameters.h"
#include "sim/server/mavlink/mavlink_setpoints.h"
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
// Emulated of both: heartbeats with the modes that ground stations know; the messages of MavlinkOffers(), at rates
// that SET_MESSAGE_INTERVAL and REQUEST_DATA_STREAM change, or once by REQUEST_MESSAGE; parameters
// (sim/server/mavlink/mavlink_parameters.h); TIMESYNC and PING; commands as COMMAND_LONG and COMMAND_INT; how it
// flies, sim/server/mavlink/mavlink_flight.h; setpoints, sim/server/mavlink/mavlink_setpoints.h. It has no missions,
// fences or rally points: their lists are empty, and what would fill them is refused. A command that it has not is
// answered as unsupported, and STATUSTEXT says why something was refused. ArduPilot streams nothing before it is
// asked to, PX4 what MavlinkOffers() says: the rates are assumed.
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
  void SetPilot(bool allows) { flight_.SetPilot(allows); }
  // The time of day less now_s, for SYSTEM_TIME; without, it tells none.
  void SetDate(double offset_s) { date_s_ = offset_s; }

 private:
  struct Stream {
    double period_s = 0;  // 0: none
    double default_s = 0;
    double next_s = 0;
    std::uint8_t group = 0;  // MAV_DATA_STREAM
  };
  // A command, in whichever of the two messages it came.
  struct Order {
    std::uint16_t command = 0;
    std::array<float, 4> param{};
    std::optional<Eigen::Vector2d> place_deg{};  // latitude, longitude
    double height_m = 0;                         // param7
    int frame = 0;                               // MAV_FRAME of the height
    bool with_frame = false;                     // it came with one
    control::wire::mavlink::Source from{};
  };

  void Handle(const control::wire::mavlink::Message& message, const control::wire::mavlink::Source& from,
              double now_s, control::Autopilot& aircraft);
  void HandleLists(const control::wire::mavlink::Message& message,
                   const control::wire::mavlink::Source& from);
  void Obey(const Order& order, double now_s, control::Autopilot& aircraft);
  std::uint8_t ResultOf(const Order& order, double now_s, control::Autopilot& aircraft);
  std::optional<double> HeightAboveHome(const Order& order) const;
  std::uint8_t TakeOff(const Order& order, double now_s, control::Autopilot& aircraft);
  std::uint8_t GoTo(const Order& order, double now_s, const control::VehicleState& state);
  std::uint8_t TellOnce(std::uint32_t id, double now_s, const control::VehicleState& state);
  std::uint8_t SetInterval(const Order& order, double now_s);
  void SetStreams(const control::wire::mavlink::RequestDataStream& request, double now_s);
  void TakeSetpoint(const std::optional<MavlinkSetpoint>& setpoint,
                    const control::wire::mavlink::Message& message, double now_s,
                    control::Autopilot& aircraft);
  void TakeAnswer(const MavlinkParameters::Answer& answer);
  bool ForMe(std::uint8_t system, std::uint8_t component) const;
  void Warn(const std::string& text);
  std::optional<control::wire::mavlink::Message> Of(std::uint32_t id, double now_s,
                                                    const control::VehicleState& state) const;
  void Say(const control::wire::mavlink::Message& message);

  MavlinkServerOptions options_;
  const control::wire::mavlink::Dialect& dialect_;
  control::wire::mavlink::Parser parser_;
  control::wire::mavlink::Sender sender_, to_others_;
  MavlinkParameters parameters_;
  MavlinkFlight flight_;
  WireCounts counts_;
  std::vector<control::wire::Bytes> out_;
  std::map<std::uint32_t, Stream> streams_;
  double next_heartbeat_s_ = 0;
  std::optional<double> date_s_;
};

}  // namespace kestrel::sim
