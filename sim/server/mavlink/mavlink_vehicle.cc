// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_vehicle.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/link/local_geodesy.h"
#include "geometry/tait_bryan.h"
#include "sim/server/mavlink/mavlink_missions.h"
#include "sim/server/mavlink/mavlink_telling.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;

// MAV_CMD
constexpr std::uint16_t kReturnCommand = 20, kLandCommand = 21, kTakeOffCommand = 22, kSetModeCommand = 176,
                        kSetHomeCommand = 179, kGoToCommand = 192, kRebootCommand = 246,
                        kStartMissionCommand = 300, kArmCommand = 400, kGetHomeCommand = 410,
                        kGetIntervalCommand = 510, kIntervalCommand = 511, kMessageCommand = 512,
                        kVersionCommand = 520;
// MAV_RESULT
constexpr std::uint8_t kAccepted = 0, kDenied = 2, kUnsupported = 3, kFailed = 4;
// MAV_MODE_FLAG, MAV_STATE, MAV_SEVERITY
constexpr std::uint8_t kCustomMode = 1, kSimulatedFlag = 32, kArmedFlag = 128;
constexpr std::uint8_t kStandby = 3, kActive = 4;
constexpr std::uint8_t kWarning = 4, kInformation = 6, kInvalidAutopilot = 8;
// MAV_FRAME of a height, also as ..._INT: above the sea, above home.
constexpr int kAboveSea = 0, kAboveSeaInt = 5, kAboveHome = 3, kAboveHomeInt = 6;
constexpr float kLargestId = 1e6F;

Statustext TextMessage(std::uint8_t severity, const std::string& text) {
  Statustext message{.severity = severity};
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

// Of a message that tells what a camera saw; null: of another.
const char* NameOfSighting(const Message& message) {
  if (std::holds_alternative<LandingTarget>(message)) return "LANDING_TARGET";
  if (std::holds_alternative<TargetRelative>(message)) return "TARGET_RELATIVE";
  if (std::holds_alternative<Odometry>(message)) return "ODOMETRY";
  if (std::holds_alternative<VisionPositionEstimate>(message)) return "VISION_POSITION_ESTIMATE";
  return nullptr;
}

std::optional<std::uint32_t> IdOf(float param) {
  if (!(param >= 0 && param < kLargestId)) return std::nullopt;
  return static_cast<std::uint32_t>(param);
}

}  // namespace

MavlinkVehicle::MavlinkVehicle(const MavlinkServerOptions& options)
    : options_(options),
      dialect_(options.dialect == "px4" ? kPx4 : kArduPilot),
      parser_(Formats()),
      sender_(static_cast<std::uint8_t>(options.system), static_cast<std::uint8_t>(options.component)),
      to_others_(sender_),
      parameters_(dialect_, options.system, options.component, options.type),
      flight_(dialect_, parameters_) {
  for (const MavlinkOffer& offer : MavlinkOffers()) {
    const double period_s = &dialect_ == &kPx4 && offer.px4_hz > 0 ? 1 / offer.px4_hz : 0;
    streams_[offer.id] = {period_s, period_s, 0, offer.stream};
  }
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
void MavlinkVehicle::Warn(const std::string& text) { Say(TextMessage(kWarning, text)); }

control::wire::Bytes MavlinkVehicle::Refusal() {
  return to_others_.Encode(TextMessage(kWarning, "refused: another client has the session"));
}

void MavlinkVehicle::Receive(std::span<const std::uint8_t> datagram, double now_s,
                             control::Autopilot& aircraft) {
  const Counts before = parser_.counts();
  for (const Frame& frame : parser_.Datagram(datagram)) {
    if (const std::optional<Message> message = Decode(frame))
      Handle(*message, {frame.system, frame.component}, now_s, aircraft);
  }
  const Counts& now = parser_.counts();
  if (now.stray_bytes > before.stray_bytes)
    counts_.CountIgnored(
        ignored::kDamaged,
        fmt::format("{} of {} bytes are of no frame{}", now.stray_bytes - before.stray_bytes, datagram.size(),
                    now.bad_checksum > before.bad_checksum ? ", by a check sum" : ""));
}

void MavlinkVehicle::Handle(const Message& message, const Source& from, double now_s,
                            control::Autopilot& aircraft) {
  if (const auto* m = std::get_if<CommandLong>(&message)) {
    if (!ForMe(m->target_system, m->target_component)) return;
    Order order{.command = m->command,
                .param = {m->param1, m->param2, m->param3, m->param4},
                .height_m = m->param7,
                .frame = &dialect_ == &kPx4 ? kAboveSea : kAboveHome,
                .from = from};
    if (std::isfinite(m->param5) && std::isfinite(m->param6) && (m->param5 != 0 || m->param6 != 0))
      order.place_deg = Eigen::Vector2d(m->param5, m->param6);
    Obey(order, now_s, aircraft);
  } else if (const auto* i = std::get_if<CommandInt>(&message)) {
    if (!ForMe(i->target_system, i->target_component)) return;
    constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();
    Order order{.command = i->command,
                .param = {i->param1, i->param2, i->param3, i->param4},
                .height_m = i->z,
                .frame = i->frame,
                .with_frame = true,
                .from = from};
    if (i->x != kNone && i->y != kNone && (i->x != 0 || i->y != 0))
      order.place_deg = Eigen::Vector2d(1e-7 * i->x, 1e-7 * i->y);
    Obey(order, now_s, aircraft);
  } else if (const auto* mode = std::get_if<control::wire::mavlink::SetMode>(&message)) {
    if (!ForMe(mode->target_system, 0)) return;
    // ArduPilot answers by the message's own number.
    const std::uint16_t answered = &dialect_ == &kPx4
                                       ? kSetModeCommand
                                       : static_cast<std::uint16_t>(control::wire::mavlink::SetMode::kId);
    Say(CommandAck{.command = answered,
                   .result = flight_.SetMode(mode->custom_mode, now_s, aircraft.State()),
                   .target_system = from.first,
                   .target_component = from.second});
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
                   .ts1 = timesync->ts1,
                   .target_system = from.first,
                   .target_component = from.second});
  } else if (const auto* ping = std::get_if<Ping>(&message)) {
    if (ping->target_system == 0 && ping->target_component == 0)
      Say(Ping{ping->time_usec, ping->seq, from.first, from.second});
  } else if (const auto* streams = std::get_if<RequestDataStream>(&message)) {
    if (ForMe(streams->target_system, streams->target_component)) SetStreams(*streams, now_s);
  } else if (const char* sighting = NameOfSighting(message)) {
    ++counts_.sightings[sighting];
  } else {
    HandleLists(message, from);
  }
}

// Parameters and missions.
void MavlinkVehicle::HandleLists(const Message& message, const Source& from) {
  if (const auto* list = std::get_if<ParamRequestList>(&message)) {
    if (!ForMe(list->target_system, list->target_component)) return;
    for (const ParamValue& value : parameters_.All()) Say(value);
  } else if (const auto* read = std::get_if<ParamRequestRead>(&message)) {
    if (ForMe(read->target_system, read->target_component)) TakeAnswer(parameters_.Read(*read));
  } else if (const auto* set = std::get_if<ParamSet>(&message)) {
    if (ForMe(set->target_system, set->target_component)) TakeAnswer(parameters_.Set(*set));
  } else if (const std::optional<MissionQuestion> question = AsMissionQuestion(message)) {
    if (!ForMe(question->target_system, question->target_component)) return;
    const MissionAnswer answer = AnswerMission(message, from);
    if (!answer.text.empty()) Warn(answer.text);
    if (answer.message) Say(*answer.message);
  }
}

void MavlinkVehicle::TakeAnswer(const MavlinkParameters::Answer& answer) {
  for (const ParamValue& value : answer.values) Say(value);
  if (!answer.text.empty()) Warn(answer.text);
}

void MavlinkVehicle::TakeSetpoint(const std::optional<MavlinkSetpoint>& setpoint, const Message& message,
                                  double now_s, control::Autopilot& aircraft) {
  if (!setpoint) {
    ++counts_.refused;
    counts_.CountIgnored(ignored::kImpossible, TextOfSetpoint(message));
    return flight_.TakeMalformed(aircraft);
  }
  ++counts_.setpoints;
  if (flight_.Take(*setpoint, now_s))
    ++counts_.followed;
  else
    counts_.CountIgnored(flight_.pilot_allows() ? ignored::kOtherMode : ignored::kPilot,
                         TextOfSetpoint(message));
}

void MavlinkVehicle::Obey(const Order& order, double now_s, control::Autopilot& aircraft) {
  const std::uint8_t result = ResultOf(order, now_s, aircraft);
  Say(CommandAck{.command = order.command,
                 .result = result,
                 .target_system = order.from.first,
                 .target_component = order.from.second});
}

std::uint8_t MavlinkVehicle::ResultOf(const Order& order, double now_s, control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  switch (order.command) {
    case kReturnCommand:
      return flight_.SetMode(MavlinkDoing::kReturn, now_s, state);
    case kLandCommand:
      return flight_.SetMode(MavlinkDoing::kLand, now_s, state);
    case kTakeOffCommand:
      return TakeOff(order, now_s, aircraft);
    case kGoToCommand:
      return GoTo(order, now_s, state);
    case kSetModeCommand: {
      const auto part = [](float value) {
        return value >= 0 && value < 256 ? static_cast<unsigned>(value) : 0U;
      };
      const std::uint32_t mode =
          &dialect_ == &kPx4 ? part(order.param[1]) << 16 | part(order.param[2]) << 24 : part(order.param[1]);
      return order.param[0] >= 1 ? flight_.SetMode(mode, now_s, state) : kDenied;
    }
    case kArmCommand:
      return flight_.Arm(order.param[0] == 1, now_s, state);
    case kSetHomeCommand:
      if (order.param[0] != 1) return kDenied;  // elsewhere than where it is
      flight_.SetHome(state.p_NB);
      return TellOnce(HomePosition::kId, now_s, state);
    case kGetHomeCommand:
      return TellOnce(HomePosition::kId, now_s, state);
    case kVersionCommand:
      return order.param[0] == 1 ? TellOnce(AutopilotVersion::kId, now_s, state) : kDenied;
    case kMessageCommand: {
      const auto id = IdOf(order.param[0]);
      return id ? TellOnce(*id, now_s, state) : kDenied;
    }
    case kIntervalCommand:
      return SetInterval(order, now_s);
    case kGetIntervalCommand: {
      const auto id = IdOf(order.param[0]);
      if (!id || *id > 65535) return kDenied;
      const auto stream = streams_.find(*id);
      const double period_s = stream == streams_.end() ? 0 : stream->second.period_s;
      const bool off = stream != streams_.end() && period_s == 0;
      Say(MessageInterval{.interval_us = off ? -1 : static_cast<std::int32_t>(std::lround(1e6 * period_s)),
                          .message_id = static_cast<std::uint16_t>(*id)});
      return kAccepted;
    }
    case kStartMissionCommand:
      Warn("refused: there is no mission");
      return kDenied;
    case kRebootCommand:
      Warn("refused: not to be rebooted");
      return kDenied;
    default:
      return kUnsupported;
  }
}

// None: it is told in no frame that is known.
std::optional<double> MavlinkVehicle::HeightAboveHome(const Order& order) const {
  if (order.frame == kAboveHome || order.frame == kAboveHomeInt) return order.height_m;
  if (order.frame != kAboveSea && order.frame != kAboveSeaInt) return std::nullopt;
  return order.height_m - (options_.origin.altitude_m - flight_.home_N().z());
}

std::uint8_t MavlinkVehicle::TakeOff(const Order& order, double now_s, control::Autopilot& aircraft) {
  const std::optional<double> height_m = HeightAboveHome(order);
  const bool above_home = order.frame == kAboveHome || order.frame == kAboveHomeInt;
  if (!height_m || (&dialect_ == &kArduPilot && !above_home)) {
    Warn(fmt::format("take-off refused: a height in frame {}", order.frame));
    return kDenied;
  }
  return flight_.TakeOff(std::isnan(*height_m) ? std::nullopt : height_m, now_s, aircraft);
}

std::uint8_t MavlinkVehicle::GoTo(const Order& order, double now_s, const control::VehicleState& state) {
  const std::optional<double> height_m = HeightAboveHome(order);
  if (!order.place_deg || !height_m) {
    Warn("refused: no place, or in a frame that is not known");
    return kDenied;
  }
  const GeodeticOrigin& origin = options_.origin;
  const control::LocalPlane plane(Radians(origin.latitude_deg), Radians(origin.longitude_deg),
                                  origin.altitude_m);
  const Eigen::Vector2d p = plane.NorthEast(Radians(order.place_deg->x()), Radians(order.place_deg->y()));
  const double z = std::isnan(*height_m) ? state.p_NB.z() : flight_.home_N().z() - *height_m;
  const float yaw = order.param[3];
  return flight_.GoTo({p.x(), p.y(), z},
                      std::isfinite(yaw) ? std::optional(static_cast<double>(yaw)) : std::nullopt, now_s,
                      state);
}

std::uint8_t MavlinkVehicle::TellOnce(std::uint32_t id, double now_s, const control::VehicleState& state) {
  const std::optional<Message> message = Of(id, now_s, state);
  if (!message) return kUnsupported;
  Say(*message);
  return kAccepted;
}

std::uint8_t MavlinkVehicle::SetInterval(const Order& order, double now_s) {
  constexpr double kFastest_s = 0.002;
  const auto id = IdOf(order.param[0]);
  const auto stream = id ? streams_.find(*id) : streams_.end();
  if (stream == streams_.end()) return kDenied;
  const double period_s = 1e-6 * static_cast<double>(order.param[1]);
  if (!std::isfinite(period_s)) return kDenied;
  stream->second.period_s = period_s < 0    ? 0
                            : period_s == 0 ? stream->second.default_s
                                            : std::max(kFastest_s, period_s);
  stream->second.next_s = now_s;
  return kAccepted;
}

void MavlinkVehicle::SetStreams(const RequestDataStream& request, double now_s) {
  constexpr int kFastest_hz = 200;
  const int rate_hz = std::min<int>(request.req_message_rate, kFastest_hz);
  for (auto& [id, stream] : streams_) {
    if (stream.group == 0 || (request.req_stream_id != 0 && request.req_stream_id != stream.group)) continue;
    stream.period_s = request.start_stop == 1 && rate_hz > 0 ? 1.0 / rate_hz : 0;
    stream.next_s = now_s;
  }
}

std::vector<control::wire::Bytes> MavlinkVehicle::Due(double now_s, control::Autopilot& aircraft) {
  flight_.Follow(now_s, aircraft);
  for (const MavlinkFlight::Text& text : flight_.TakeTexts())
    Say(TextMessage(text.warning ? kWarning : kInformation, text.text));
  const control::VehicleState state = aircraft.State();
  if (flight_.TakeChanged() || now_s >= next_heartbeat_s_) {
    next_heartbeat_s_ = now_s + 1;
    const bool flying = state.mode != control::FlightMode::kStopped;
    Say(Heartbeat{.custom_mode = flight_.mode(),
                  .type = static_cast<std::uint8_t>(options_.type),
                  .autopilot = dialect_.autopilot,
                  .base_mode = static_cast<std::uint8_t>(kCustomMode | kSimulatedFlag | flight_.base_mode() |
                                                         (flight_.armed() ? kArmedFlag : 0)),
                  .system_status = flying ? kActive : kStandby});
  }
  for (auto& [id, stream] : streams_) {
    if (stream.period_s == 0 || now_s < stream.next_s) continue;
    stream.next_s = std::max(stream.next_s + stream.period_s, now_s);
    if (const std::optional<Message> message = Of(id, now_s, state)) Say(*message);
  }
  return std::exchange(out_, {});
}

std::optional<Message> MavlinkVehicle::Of(std::uint32_t id, double now_s,
                                          const control::VehicleState& state) const {
  return Tell(id, {.state = state,
                   .dialect = dialect_,
                   .origin = options_.origin,
                   .home_N = flight_.home_N(),
                   .doing = flight_.doing(),
                   .armed = flight_.armed(),
                   .pilot_allows = flight_.pilot_allows(),
                   .system = options_.system,
                   .switch_channel = options_.switch_channel,
                   .unix_s = date_s_ ? now_s + *date_s_ : 0});
}

}  // namespace kestrel::sim
