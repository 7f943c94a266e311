// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/clock_sync.h"
#include "base/yaml/fields.h"
#include "control/link/autopilot_link.h"
#include "control/sighting.h"
#include "control/wire/mavlink_dialects.h"

namespace kestrel::control {

struct MavlinkOptions {
  double setpoint_hz = 30;
  double state_hz = 50;
  bool take_control = false;  // once setpoints are streaming
  bool arm = false;
  bool stand_by = false;
  int switch_channel = 0;  // as RC_CHANNELS counts
  double switch_min_us = 1700, switch_max_us = 2300;
  int autopilot_system = 0;
  int system = 1, component = 191;  // MAV_COMP_ID_ONBOARD_COMPUTER
  // What is told of what the camera sees, beside setpoints.
  std::string landing_target = "none", vision_position = "none";
};

inline void Fields(FieldVisitor& v, MavlinkOptions& o) {
  v({"setpoint_hz", "rate at which a setpoint is repeated while it is fresh"}, o.setpoint_hz, 20.0, 200.0);
  v({"state_hz", "rate of attitude and position that is requested from the autopilot"}, o.state_hz, 5.0,
    400.0);
  v({"take_control",
     "request the mode that follows setpoints (OFFBOARD, GUIDED); false: the pilot changes to it"},
    o.take_control);
  v({"arm", "arm the motors for a take-off, once the mode that follows setpoints is active"}, o.arm);
  v({"stand_by",
     "stream velocity zero while another mode is active, as PX4 lets the pilot change to OFFBOARD only then"},
    o.stand_by);
  v({"switch_channel", "RC channel of a pilot's switch that must be on as well; 0: none"}, o.switch_channel,
    0, 18);
  v(Renamed("switch_min_us", "switch_least_us",
            "shortest pulse of switch_channel with which the pilot's switch counts as on"),
    o.switch_min_us, 500.0, 2500.0);
  v(Renamed("switch_max_us", "switch_most_us",
            "longest pulse of switch_channel with which the pilot's switch counts as on"),
    o.switch_max_us, 500.0, 2500.0);
  v({"autopilot_system", "MAVLink system ID of the autopilot; 0: the first that is heard"},
    o.autopilot_system, 0, 255);
  v({"system", "MAVLink system ID of this program"}, o.system, 1, 255);
  v({"component", "MAVLink component ID of this program; 191: onboard computer"}, o.component, 1, 255);
  v({"landing_target",
     "message that tells the autopilot where the pad is, for its own precision landing; target_relative is "
     "of PX4 "
     "alone"},
    o.landing_target, {"none", "landing_target", "target_relative"});
  v({"vision_position",
     "message that tells the autopilot the pose by the camera, with covariance and time of exposure, for its "
     "own "
     "estimator; odometry is of PX4 alone"},
    o.vision_position, {"none", "odometry", "vision_position_estimate"});
}

// The offset of a clock that answers TIMESYNC: by the answer of the last while that came back the soonest,
// which was read half its round trip ago.
class AskedClock {
 public:
  static constexpr double kWindow_s = 10;

  std::int64_t Ask(double ours_s);  // the question's own time, ns
  // False: to no question of ours, or to one that was answered.
  bool Answer(std::int64_t asked_ns, std::int64_t their_ns, double ours_s);
  std::optional<double> Offset(double ours_s) const;  // ours - theirs

 private:
  struct Sample {
    double at_s = 0, round_trip_s = 0, offset_s = 0;
  };
  std::deque<std::int64_t> asked_;
  std::deque<Sample> samples_;
};

// The companion's side of MAVLink, without its socket: datagrams, or a stream, and times in, messages out. Times are in s
// on one monotonic clock, ours. Everything of control/link/mavlink_link.h is said there.
class MavlinkSession {
 public:
  static constexpr double kSilent_s = 3;  // without a heartbeat for longer, nobody is there

  explicit MavlinkSession(const MavlinkOptions& options);

  // Whether it holds a heartbeat of an autopilot that this session could be with.
  bool IsAutopilot(std::span<const std::uint8_t> datagram) const;
  void Receive(std::span<const std::uint8_t> datagram, double now_s);
  // The same of a stream, cut anywhere; and that a new one begins, in which no message goes on.
  void ReceiveStream(std::span<const std::uint8_t> bytes, double now_s);
  void BeginStream() { parser_.Datagram({}); }
  std::vector<wire::Bytes> Due(double now_s);  // what is to be sent now; to be asked every few milliseconds

  void Send(const Setpoint& setpoint, double now_s);
  void Silence();
  void TakeControl() { asks_ = true; }
  void See(const Sighting& sighting) { sighting_ = sighting; }
  void Aid() { aid_refused_ = true; }

  VehicleState State() const { return state_; }
  LinkHealth Health(double now_s) const;
  bool Open(double now_s) const;  // an autopilot is there

 private:
  // Something that is asked for until it is so.
  struct Ask {
    std::optional<double> asked_s, accepted_s;
    std::uint8_t times = 0;
    std::optional<std::uint8_t> refused;  // MAV_RESULT
    bool Due(double now_s);
  };
  struct Stream {
    std::uint32_t id = 0;
    double rate_hz = 0;
    int asked = 0, came = 0;  // came: since since_s
    double since_s = 0;
  };
  struct Latest {
    std::optional<std::uint32_t> time_boot_ms;
    int older = 0;  // messages, without a newer one among them
  };
  struct Numbered {
    std::uint8_t sequence = 0;
    double at_s = 0;
  };

  void Take(const std::vector<wire::mavlink::Frame>& frames, const wire::mavlink::Counts& before,
            double now_s);
  void Begin(const wire::mavlink::Frame& frame, const wire::mavlink::Heartbeat& heartbeat, double now_s);
  void Restart(double now_s);
  void Handle(const wire::mavlink::Frame& frame, const wire::mavlink::Message& message, double now_s);
  bool Newer(Latest& latest, std::uint32_t time_boot_ms, double now_s);
  bool InOrder(const wire::mavlink::Frame& frame, double now_s);
  void HandleHeartbeat(const wire::mavlink::Heartbeat& heartbeat, double now_s);
  void TakeAck(const wire::mavlink::CommandAck& ack, double now_s);
  void HandleMotion(const wire::mavlink::Message& message, std::uint32_t time_boot_ms, double now_s);
  void Count(std::uint32_t id);
  double ToOurs(double their_s, double now_s) const;

  void AskForStreams(double now_s);
  void AskForControl(double now_s);
  void SendSetpoint(double now_s);
  void TellSighting();
  std::string SightingError() const;
  bool StandsBy() const;
  bool InMode() const;
  bool Armed() const;
  bool Fresh(double now_s) const;
  bool TakingOff() const;
  std::optional<bool> PilotAllows(double now_s) const;
  std::string Error(double now_s) const;
  void Say(const wire::mavlink::Message& message);

  MavlinkOptions options_;
  wire::mavlink::Parser parser_;
  wire::mavlink::Sender sender_;
  std::vector<wire::Bytes> out_;

  std::optional<wire::mavlink::Source> source_;
  const wire::mavlink::Dialect* dialect_ = nullptr;
  wire::mavlink::Target target_;
  std::optional<wire::mavlink::Heartbeat> heartbeat_;
  double heartbeat_s_ = 0;
  std::string stranger_;  // an autopilot that cannot be flown, in words

  wire::mavlink::Telemetry telemetry_;
  ClockSync heard_clock_;
  AskedClock asked_clock_;
  Latest attitude_, position_, channels_;
  bool by_quaternion_ = false;
  std::map<std::uint32_t, Numbered> numbered_;
  VehicleState state_;
  double moved_s_ = 0, turned_s_ = 0;  // when the newest position and attitude of telemetry_ were heard
  std::optional<double> state_s_;
  std::optional<wire::mavlink::RcChannels> rc_;
  double rc_s_ = 0;
  std::string text_;  // the autopilot's last warning

  std::optional<Setpoint> setpoint_;
  double setpoint_s_ = 0;              // when it was given to us
  std::optional<double> streaming_s_;  // since when there has been a fresh one
  double next_s_ = 0;                  // when it is to be repeated
  std::optional<double> yaw_;          // of attitudes on the wire
  double yaw_s_ = 0;                   // when it was that
  std::optional<Sighting> sighting_;   // that was not told yet
  std::string setpoint_error_;
  bool aid_refused_ = false;

  bool had_ = false;  // the mode, when it was last heard of
  bool asks_;         // for the mode, where it is another
  Ask mode_, arm_, take_off_;
  std::vector<Stream> streams_;
  double next_heartbeat_s_ = 0, next_timesync_s_ = 0;
  std::uint64_t received_ = 0, refused_ = 0, sent_ = 0;
};

}  // namespace kestrel::control
