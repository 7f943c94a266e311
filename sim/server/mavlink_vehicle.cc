// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink_vehicle.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;

constexpr double kNoTakeOff_s = 10;  // after arming: disarmed again (COM_DISARM_PRFLT, DISARM_DELAY)
constexpr double kLead_s = 1;        // of setpoints before OFFBOARD
constexpr double kLanding_m_s = 0.5;
constexpr double kClearOfGround_m = 0.3;
constexpr std::uint16_t kSwitchOn_us = 2000, kSwitchOff_us = 1000, kCentre_us = 1500, kUnused_us = 65535;

// Modes of our own choice: what it does on its own, and what the pilot flies in.
constexpr std::uint32_t kPx4Loiter = 4U << 16 | 3U << 24, kPx4Position = 3U << 16;
constexpr std::uint32_t kArduPilotLoiter = 5;

constexpr std::uint16_t kTakeOffCommand = 22, kSetModeCommand = 176, kArmCommand = 400,
                        kIntervalCommand = 511, kMessageCommand = 512;
// MAV_RESULT
constexpr std::uint8_t kAccepted = 0, kTemporarilyRejected = 1, kDenied = 2, kUnsupported = 3, kFailed = 4;
// MAV_MODE_FLAG, MAV_STATE, MAV_LANDED_STATE, MAV_SEVERITY
constexpr std::uint8_t kCustomMode = 1, kSimulatedFlag = 32, kArmedFlag = 128;
constexpr std::uint8_t kStandby = 3, kActive = 4;
constexpr std::uint8_t kOnGround = 1, kInAir = 2, kTakingOff = 3;
constexpr std::uint8_t kWarning = 4, kInvalidAutopilot = 8;

float Float(double value) { return static_cast<float>(value); }
template <class T>
T Whole(double value) {
  constexpr double least = std::numeric_limits<T>::min(), most = std::numeric_limits<T>::max();
  return static_cast<T>(std::clamp(std::round(value), least, most));
}

std::uint32_t HoldMode(const Dialect& dialect) { return &dialect == &kPx4 ? kPx4Loiter : kArduPilotLoiter; }
std::uint32_t PilotMode(const Dialect& dialect) {
  return &dialect == &kPx4 ? kPx4Position : kArduPilotLoiter;
}

std::uint32_t BootMs(const control::VehicleState& state) {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::max(0.0, 1e3 * state.t_s)));
}

Statustext Warning(const std::string& text) {
  Statustext message{.severity = kWarning};
  std::copy_n(text.begin(), std::min(text.size(), message.text.size()), message.text.begin());
  return message;
}

// In words; of another message nothing.
std::string TextOfSetpoint(const Message& message) {
  if (const auto* p = std::get_if<SetPositionTargetLocalNed>(&message))
    return fmt::format(
        "SET_POSITION_TARGET_LOCAL_NED, frame {}, mask 0x{:x}, position {:g} {:g} {:g}, velocity {:g} {:g} "
        "{:g}, yaw {:g}, yaw rate {:g}",
        p->coordinate_frame, p->type_mask, p->x, p->y, p->z, p->vx, p->vy, p->vz, p->yaw, p->yaw_rate);
  if (const auto* a = std::get_if<SetAttitudeTarget>(&message))
    return fmt::format("SET_ATTITUDE_TARGET, mask 0x{:x}, attitude {:g}, thrust {:g}, yaw rate {:g}",
                       a->type_mask, fmt::join(a->q, " "), a->thrust, a->body_yaw_rate);
  return {};
}

}  // namespace

MavlinkVehicle::MavlinkVehicle(const MavlinkServerOptions& options)
    : options_(options),
      dialect_(options.dialect == "px4" ? kPx4 : kArduPilot),
      parser_(Formats()),
      sender_(static_cast<std::uint8_t>(options.system), static_cast<std::uint8_t>(options.component)),
      to_others_(sender_),
      mode_(HoldMode(dialect_)) {
  const bool px4 = &dialect_ == &kPx4;
  const auto offer = [&](std::uint32_t id, double rate_hz) {
    const double period_s = px4 && rate_hz > 0 ? 1 / rate_hz : 0;
    streams_[id] = {period_s, period_s, 0};
  };
  offer(Attitude::kId, 50);
  offer(AttitudeQuaternion::kId, 0);
  offer(LocalPositionNed::kId, 30);
  offer(GlobalPositionInt::kId, 10);
  offer(ExtendedSysState::kId, 1);
  offer(RcChannels::kId, 0);
  offer(SystemTime::kId, 1);
}

bool MavlinkVehicle::OpensSession(std::span<const std::uint8_t> datagram) const {
  for (const Frame& frame : Parser(Formats()).Datagram(datagram)) {
    const std::optional<Message> message = Decode(frame);
    const auto* heartbeat = message ? std::get_if<Heartbeat>(&*message) : nullptr;
    if (heartbeat != nullptr && heartbeat->autopilot == kInvalidAutopilot) return true;
  }
  return false;
}

bool MavlinkVehicle::ForMe(std::uint8_t system, std::uint8_t component) const {
  return (system == 0 || system == options_.system) && (component == 0 || component == options_.component);
}

void MavlinkVehicle::Say(const Message& message) { out_.push_back(sender_.Encode(message)); }

void MavlinkVehicle::Warn(const std::string& text) { Say(Warning(text)); }

control::wire::Bytes MavlinkVehicle::Refusal() {
  return to_others_.Encode(Warning("refused: another client has the session"));
}

void MavlinkVehicle::Receive(std::span<const std::uint8_t> datagram, double now_s,
                             control::Autopilot& aircraft) {
  const Counts before = parser_.counts();
  for (const Frame& frame : parser_.Datagram(datagram)) {
    if (const std::optional<Message> message = Decode(frame)) Handle(*message, now_s, aircraft);
  }
  const Counts& now = parser_.counts();
  if (now.stray_bytes > before.stray_bytes)
    counts_.CountIgnored(
        ignored::kDamaged,
        fmt::format("{} of {} bytes are of no frame{}", now.stray_bytes - before.stray_bytes, datagram.size(),
                    now.bad_checksum > before.bad_checksum ? ", by a check sum" : ""));
}

void MavlinkVehicle::Handle(const Message& message, double now_s, control::Autopilot& aircraft) {
  if (const auto* command = std::get_if<CommandLong>(&message)) {
    if (ForMe(command->target_system, command->target_component)) Command(*command, now_s, aircraft);
  } else if (const auto* mode = std::get_if<control::wire::mavlink::SetMode>(&message)) {
    if (ForMe(mode->target_system, 0)) SetMode(mode->custom_mode, now_s);
  } else if (const auto* position = std::get_if<SetPositionTargetLocalNed>(&message)) {
    if (ForMe(position->target_system, position->target_component))
      TakeSetpoint(MavlinkSetpoint::Read(*position, aircraft.State(), dialect_), *position, now_s, aircraft);
    else
      counts_.CountIgnored(ignored::kToAnother, fmt::format("to system {}", position->target_system));
  } else if (const auto* attitude = std::get_if<SetAttitudeTarget>(&message)) {
    if (ForMe(attitude->target_system, attitude->target_component))
      TakeSetpoint(MavlinkSetpoint::Read(*attitude, dialect_), *attitude, now_s, aircraft);
    else
      counts_.CountIgnored(ignored::kToAnother, fmt::format("to system {}", attitude->target_system));
  } else if (const auto* timesync = std::get_if<Timesync>(&message)) {
    if (timesync->tc1 == 0)
      Say(Timesync{.tc1 = std::max<std::int64_t>(1, std::llround(1e9 * aircraft.State().t_s)),
                   .ts1 = timesync->ts1});
  }
}

void MavlinkVehicle::TakeSetpoint(const std::optional<MavlinkSetpoint>& setpoint, const Message& message,
                                  double now_s, control::Autopilot& aircraft) {
  const bool following = mode_ == dialect_.setpoint_mode;
  if (!setpoint) {
    ++counts_.refused;
    counts_.CountIgnored(ignored::kImpossible, TextOfSetpoint(message));
    if (&dialect_ == &kArduPilot && following) setpoint_.reset(), Stop(aircraft);
    return;
  }
  if (!streaming_s_ || now_s - setpoint_s_ > 1 / dialect_.slowest_setpoints_hz) streaming_s_ = now_s;
  setpoint_s_ = now_s;
  ++counts_.setpoints;
  if (following)
    setpoint_ = setpoint, ++counts_.followed;
  else
    counts_.CountIgnored(pilot_allows_ ? ignored::kOtherMode : ignored::kPilot, TextOfSetpoint(message));
}

void MavlinkVehicle::Command(const CommandLong& command, double now_s, control::Autopilot& aircraft) {
  std::uint8_t result = kUnsupported;
  switch (command.command) {
    case kSetModeCommand: {
      const auto part = [](float value) {
        return value >= 0 && value < 256 ? static_cast<unsigned>(value) : 0U;
      };
      const std::uint32_t mode =
          &dialect_ == &kPx4 ? part(command.param2) << 16 | part(command.param3) << 24 : part(command.param2);
      result = command.param1 >= 1 ? SetMode(mode, now_s) : kDenied;
      break;
    }
    case kArmCommand:
      result = Arm(command.param1 == 1, now_s, aircraft.State());
      break;
    case kTakeOffCommand:
      result = TakeOff(command.param7, aircraft);
      break;
    case kIntervalCommand:
      result = SetInterval(command, now_s);
      break;
    case kMessageCommand:
      if (command.param1 >= 0 && command.param1 < 1e6F &&
          streams_.contains(static_cast<std::uint32_t>(command.param1))) {
        Say(Of(static_cast<std::uint32_t>(command.param1), aircraft.State()));
        result = kAccepted;
      }
      break;
    default:
      break;
  }
  Say(CommandAck{.command = command.command, .result = result});
}

std::uint8_t MavlinkVehicle::SetMode(std::uint32_t custom_mode, double now_s) {
  if (custom_mode != dialect_.setpoint_mode && custom_mode != dialect_.land_mode &&
      custom_mode != HoldMode(dialect_) && custom_mode != PilotMode(dialect_))
    return kDenied;
  if (!pilot_allows_ && custom_mode != PilotMode(dialect_)) {
    Warn("mode refused: the pilot's switch");
    return kDenied;
  }
  if (custom_mode == dialect_.setpoint_mode && dialect_.setpoints_first) {
    const bool coming = streaming_s_ && now_s - setpoint_s_ <= 1 / dialect_.slowest_setpoints_hz;
    if (!coming || now_s - *streaming_s_ < kLead_s) {
      Warn("offboard refused: no setpoints");
      return kTemporarilyRejected;
    }
  }
  if (mode_ != custom_mode) setpoint_.reset();
  mode_ = custom_mode;
  next_heartbeat_s_ = now_s;
  return kAccepted;
}

std::uint8_t MavlinkVehicle::Arm(bool armed, double now_s, const control::VehicleState& state) {
  const bool on_ground = state.mode == control::FlightMode::kStopped;
  if (armed == armed_) return kAccepted;
  if (!on_ground) return kDenied;
  armed_ = armed, armed_s_ = now_s, flew_ = false;
  next_heartbeat_s_ = now_s;
  return kAccepted;
}

std::uint8_t MavlinkVehicle::TakeOff(double param7, control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  const bool px4 = &dialect_ == &kPx4;
  // PX4 is told the height above the sea, ArduPilot that above home.
  const double z_N = px4 ? options_.origin.altitude_m - param7 : -param7;
  if (!armed_ || !pilot_allows_ || state.mode != control::FlightMode::kStopped) return kFailed;
  if (!px4 && mode_ != dialect_.setpoint_mode) return kFailed;
  if (!(z_N < state.p_NB.z() - kClearOfGround_m)) return kFailed;
  if (px4) mode_ = HoldMode(dialect_);
  setpoint_.reset();
  aircraft.Send(control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), z_N}, YawOf(state.R_NB)});
  return kAccepted;
}

std::uint8_t MavlinkVehicle::SetInterval(const CommandLong& command, double now_s) {
  if (!(command.param1 >= 0 && command.param1 < 1e6F)) return kDenied;
  const auto stream = streams_.find(static_cast<std::uint32_t>(command.param1));
  if (stream == streams_.end()) return kDenied;
  constexpr double kFastest_s = 0.002;
  const double period_s = 1e-6 * static_cast<double>(command.param2);
  if (period_s < 0) {
    stream->second.period_s = 0;
  } else if (period_s == 0) {
    stream->second.period_s = stream->second.default_s;
  } else if (std::isfinite(period_s)) {
    stream->second.period_s = std::max(kFastest_s, period_s);
  } else {
    return kDenied;
  }
  stream->second.next_s = now_s;
  return kAccepted;
}

void MavlinkVehicle::SetPilot(bool allows) { pilot_allows_ = allows; }

// Standing still, once: then the aircraft holds its place by its own time-out.
void MavlinkVehicle::Stop(control::Autopilot& aircraft) {
  if (armed_ && aircraft.State().mode != control::FlightMode::kStopped)
    aircraft.Send(control::VelocitySetpoint{});
}

void MavlinkVehicle::Follow(double now_s, control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  const bool px4 = &dialect_ == &kPx4;
  const bool stopped = state.mode == control::FlightMode::kStopped;
  if (!std::exchange(begun_, true)) armed_ = flew_ = !stopped, armed_s_ = now_s;
  flew_ = flew_ || !stopped;
  if (armed_ && stopped && (flew_ || now_s - armed_s_ > kNoTakeOff_s)) {
    armed_ = flew_ = false, setpoint_.reset();
    next_heartbeat_s_ = now_s;
    if (mode_ == dialect_.land_mode) mode_ = HoldMode(dialect_);
  }
  if (pilot_allows_ != std::exchange(pilot_was_, pilot_allows_)) {
    next_heartbeat_s_ = now_s;
    if (pilot_allows_) {
      SetMode(dialect_.setpoint_mode, now_s);
    } else {
      mode_ = PilotMode(dialect_), setpoint_.reset();
      Stop(aircraft);
    }
  }
  if (mode_ == dialect_.land_mode && armed_ && !stopped)
    aircraft.Send(control::VelocitySetpoint{{0, 0, kLanding_m_s}, 0});
  if (mode_ != dialect_.setpoint_mode) return;
  const bool late = now_s - setpoint_s_ > dialect_.setpoint_timeout_s;
  if (px4 && late) {
    mode_ = HoldMode(dialect_), setpoint_.reset(), streaming_s_.reset();
    next_heartbeat_s_ = now_s;
    Warn("no offboard setpoints: holding");
    return Stop(aircraft);
  }
  if (!setpoint_) return;
  if (late && !setpoint_->IsPosition()) {
    setpoint_.reset();
    return Stop(aircraft);
  }
  // ArduPilot leaves the ground by TAKEOFF alone.
  if (armed_ && (px4 || !stopped)) aircraft.Send(setpoint_->At(state));
}

std::vector<control::wire::Bytes> MavlinkVehicle::Due(double now_s, control::Autopilot& aircraft) {
  Follow(now_s, aircraft);
  const control::VehicleState state = aircraft.State();
  if (now_s >= next_heartbeat_s_) {
    next_heartbeat_s_ = now_s + 1;
    const bool flying = state.mode != control::FlightMode::kStopped;
    Say(Heartbeat{
        .custom_mode = mode_,
        .type = static_cast<std::uint8_t>(options_.type),
        .autopilot = dialect_.autopilot,
        .base_mode = static_cast<std::uint8_t>(kCustomMode | kSimulatedFlag | (armed_ ? kArmedFlag : 0)),
        .system_status = flying ? kActive : kStandby});
  }
  for (auto& [id, stream] : streams_) {
    if (stream.period_s == 0 || now_s < stream.next_s) continue;
    stream.next_s = std::max(stream.next_s + stream.period_s, now_s);
    Say(Of(id, state));
  }
  return std::exchange(out_, {});
}

Message MavlinkVehicle::Of(std::uint32_t id, const control::VehicleState& state) const {
  const std::uint32_t ms = BootMs(state);
  const TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  switch (id) {
    case Attitude::kId:
      return Attitude{ms,
                      Float(angles.roll),
                      Float(angles.pitch),
                      Float(angles.yaw),
                      Float(state.w_B.x()),
                      Float(state.w_B.y()),
                      Float(state.w_B.z())};
    case AttitudeQuaternion::kId: {
      const Eigen::Quaterniond q = state.R_NB.normalized();
      return AttitudeQuaternion{.time_boot_ms = ms,
                                .q1 = Float(q.w()),
                                .q2 = Float(q.x()),
                                .q3 = Float(q.y()),
                                .q4 = Float(q.z()),
                                .rollspeed = Float(state.w_B.x()),
                                .pitchspeed = Float(state.w_B.y()),
                                .yawspeed = Float(state.w_B.z())};
    }
    case LocalPositionNed::kId:
      return LocalPositionNed{ms,
                              Float(state.p_NB.x()),
                              Float(state.p_NB.y()),
                              Float(state.p_NB.z()),
                              Float(state.v_N.x()),
                              Float(state.v_N.y()),
                              Float(state.v_N.z())};
    case GlobalPositionInt::kId: {
      const GeodeticPosition place = GeodeticOf(options_.origin, state.p_NB);
      const double heading_deg = Degrees(angles.yaw);
      return GlobalPositionInt{
          .time_boot_ms = ms,
          .lat = Whole<std::int32_t>(1e7 * place.latitude_deg),
          .lon = Whole<std::int32_t>(1e7 * place.longitude_deg),
          .alt = Whole<std::int32_t>(1e3 * place.altitude_m),
          .relative_alt = Whole<std::int32_t>(-1e3 * state.p_NB.z()),
          .vx = Whole<std::int16_t>(1e2 * state.v_N.x()),
          .vy = Whole<std::int16_t>(1e2 * state.v_N.y()),
          .vz = Whole<std::int16_t>(1e2 * state.v_N.z()),
          .hdg = static_cast<std::uint16_t>(
              std::lround(1e2 * (heading_deg < 0 ? heading_deg + 360 : heading_deg)) % 36000)};
    }
    case ExtendedSysState::kId: {
      const bool stopped = state.mode == control::FlightMode::kStopped;
      const bool rising = state.mode == control::FlightMode::kTakeOff;
      return ExtendedSysState{.landed_state = stopped ? kOnGround : rising ? kTakingOff : kInAir};
    }
    case RcChannels::kId: {
      RcChannels channels{.time_boot_ms = ms, .chancount = 8, .rssi = 254};
      channels.chan_raw.fill(kUnused_us);
      channels.chancount = static_cast<std::uint8_t>(std::max(8, options_.switch_channel));
      std::fill_n(channels.chan_raw.begin(), channels.chancount, kCentre_us);
      channels.chan_raw[static_cast<std::size_t>(options_.switch_channel - 1)] =
          pilot_allows_ ? kSwitchOn_us : kSwitchOff_us;
      return channels;
    }
    default:
      return SystemTime{.time_boot_ms = ms};
  }
}

}  // namespace kestrel::sim
