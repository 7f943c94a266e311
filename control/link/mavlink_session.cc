// SPDX-License-Identifier: Apache-2.0
#include "control/link/mavlink_session.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "base/printable.h"
#include "control/wire/mavlink_sightings.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using namespace wire::mavlink;

constexpr double kAgain_s = 1;        // a question without an answer is asked again
constexpr double kAccepted_s = 2;     // until what was accepted shows in a heartbeat
constexpr double kLead_s = 1.2;       // of setpoints before the mode, where it wants them: PX4, 1 s
constexpr double kStandBy_s = 0.1;    // between setpoints of standing by
constexpr double kTimesync_s = 0.5;   // between questions
constexpr double kOtherClock_s = 1;   // TIMESYNC and time_boot_ms are not of one clock
constexpr double kSwitchStale_s = 2;  // the pilot's channels
constexpr double kStateStale_s = 0.5;
constexpr int kRestarted = 10;     // older messages in a row: its clock began anew
constexpr double kOneLap_s = 0.5;  // in which no 128 frames come
constexpr int kEagerAsks = 5;      // for a stream; then less often
constexpr double kPatience = 5;    // so much
constexpr double kClimb_m = 0.3;   // a position so much above the ground is a take-off

constexpr std::uint16_t kCommandTakeOff = 22, kCommandSetMode = 176, kCommandArm = 400;
constexpr std::uint8_t kAccepted = 0, kInProgress = 5;  // MAV_RESULT
constexpr std::uint8_t kArmedFlag = 128, kSimulatedFlag = 32, kInvalidAutopilot = 8, kWarning = 4;

// MAV_TYPE of what flies as a copter: in others custom_mode means something else.
constexpr std::array<std::uint8_t, 8> kRotorcraft{2, 3, 4, 13, 14, 15, 29, 35};

const char* ModeName(const Dialect& dialect) { return &dialect == &kPx4 ? "OFFBOARD" : "GUIDED"; }

// It comes to terminals and logs, from whoever sends it.
std::string Text(const std::array<char, 50>& text) {
  return Printable({text.begin(), std::find(text.begin(), text.end(), '\0')});
}

}  // namespace

std::int64_t AskedClock::Ask(double ours_s) {
  constexpr std::size_t kMost = 20;
  asked_.push_back(std::llround(1e9 * ours_s));
  if (asked_.size() > kMost) asked_.pop_front();
  return asked_.back();
}

bool AskedClock::Answer(std::int64_t asked_ns, std::int64_t their_ns, double ours_s) {
  const auto question = std::ranges::find(asked_, asked_ns);
  if (question == asked_.end()) return false;
  asked_.erase(question);
  const double asked_s = 1e-9 * static_cast<double>(asked_ns);
  const double their_s = 1e-9 * static_cast<double>(their_ns);
  samples_.push_back({ours_s, ours_s - asked_s, (asked_s + ours_s) / 2 - their_s});
  while (samples_.front().at_s < ours_s - kWindow_s) samples_.pop_front();
  return true;
}

std::optional<double> AskedClock::Offset(double ours_s) const {
  const Sample* best = nullptr;
  for (const Sample& sample : samples_) {
    if (sample.at_s < ours_s - kWindow_s) continue;
    if (best == nullptr || sample.round_trip_s < best->round_trip_s) best = &sample;
  }
  if (best == nullptr) return std::nullopt;
  return best->offset_s;
}

bool MavlinkSession::Ask::Due(double now_s) {
  if (accepted_s && now_s < *accepted_s + kAccepted_s) return false;
  if (asked_s && now_s < *asked_s + kAgain_s) return false;
  asked_s = now_s;
  return true;
}

MavlinkSession::MavlinkSession(const MavlinkOptions& options)
    : options_(options),
      parser_(Formats()),
      sender_(static_cast<std::uint8_t>(options.system), static_cast<std::uint8_t>(options.component)),
      asks_(options.take_control) {}

bool MavlinkSession::IsAutopilot(std::span<const std::uint8_t> datagram) const {
  for (const Frame& frame : Parser(Formats()).Datagram(datagram)) {
    const std::optional<Message> message = Decode(frame);
    const auto* heartbeat = message ? std::get_if<Heartbeat>(&*message) : nullptr;
    if (heartbeat != nullptr && heartbeat->autopilot != kInvalidAutopilot &&
        (options_.autopilot_system == 0 || options_.autopilot_system == frame.system))
      return true;
  }
  return false;
}

bool MavlinkSession::Open(double now_s) const { return heartbeat_ && now_s - heartbeat_s_ <= kSilent_s; }

void MavlinkSession::Receive(std::span<const std::uint8_t> datagram, double now_s) {
  const Counts before = parser_.counts();
  Take(parser_.Datagram(datagram), before, now_s);
}

void MavlinkSession::ReceiveStream(std::span<const std::uint8_t> bytes, double now_s) {
  const Counts before = parser_.counts();
  Take(parser_.Stream(bytes), before, now_s);
}

// before: what was counted before they came.
void MavlinkSession::Take(const std::vector<Frame>& frames, const Counts& before, double now_s) {
  for (const Frame& frame : frames) {
    const std::optional<Message> message = Decode(frame);
    if (!message) continue;
    const Source source{frame.system, frame.component};
    const auto* heartbeat = std::get_if<Heartbeat>(&*message);
    if (heartbeat != nullptr && !Open(now_s) && (source_ != source || DialectOf(*heartbeat) != dialect_))
      Begin(frame, *heartbeat, now_s);
    if (source_ == source) Handle(frame, *message, now_s);
    // Of who refuses to be our autopilot.
    const auto* text = std::get_if<Statustext>(&*message);
    if (text != nullptr && !heartbeat_ && text->severity <= kWarning) stranger_ = Text(text->text);
  }
  refused_ += parser_.counts().unknown - before.unknown;
  if (parser_.counts().stray_bytes > before.stray_bytes) ++refused_;
}

void MavlinkSession::Begin(const Frame& frame, const Heartbeat& heartbeat, double now_s) {
  if (heartbeat.autopilot == kInvalidAutopilot) return;  // not an autopilot
  if (options_.autopilot_system != 0 && options_.autopilot_system != frame.system) return;
  const Dialect* dialect = DialectOf(heartbeat);
  if (dialect == nullptr) {
    stranger_ = "MAV_AUTOPILOT " + std::to_string(heartbeat.autopilot) + " is neither PX4 nor ArduPilot";
    return;
  }
  if (std::ranges::find(kRotorcraft, heartbeat.type) == kRotorcraft.end()) {
    stranger_ = "MAV_TYPE " + std::to_string(heartbeat.type) + " is no rotorcraft";
    return;
  }
  stranger_.clear();
  dialect_ = dialect;
  source_ = {frame.system, frame.component};
  target_ = {frame.system, frame.component};
  heartbeat_.reset();
  Restart(now_s);
}

// What was heard of it is of another flight. Whether the pilot had taken over is not forgotten.
void MavlinkSession::Restart(double now_s) {
  telemetry_ = {};
  if (heartbeat_) telemetry_.Handle(*heartbeat_);
  if (setpoint_) telemetry_.Sent(*setpoint_);
  heard_clock_ = {}, asked_clock_ = {};
  attitude_ = position_ = channels_ = {};
  by_quaternion_ = false;
  numbered_.clear();
  rc_.reset(), yaw_.reset();
  mode_ = arm_ = take_off_ = {};
  text_.clear();
  next_timesync_s_ = now_s;
  streams_ = {{AttitudeQuaternion::kId, options_.state_hz},
              {LocalPositionNed::kId, options_.state_hz},
              {ExtendedSysState::kId, 5}};
  if (options_.switch_channel != 0) streams_.push_back({RcChannels::kId, 5});
  for (Stream& stream : streams_) stream.since_s = -std::numeric_limits<double>::infinity();
}

// Not of a message that came before. A clock that began anew is known by many older ones in a row: a single
// one was only late.
bool MavlinkSession::Newer(Latest& latest, std::uint32_t time_boot_ms, double now_s) {
  if (latest.time_boot_ms) {
    const auto ahead = static_cast<std::int32_t>(time_boot_ms - *latest.time_boot_ms);
    if (ahead <= 0) {
      ++refused_;
      if (ahead < 0 && ++latest.older >= kRestarted) Restart(now_s);
      return false;
    }
  }
  latest = {time_boot_ms, 0};
  return true;
}

// The same for messages that have no time: by the numbers of their frames, as long as these tell.
bool MavlinkSession::InOrder(const Frame& frame, double now_s) {
  const auto before = numbered_.find(frame.id);
  if (before != numbered_.end() && now_s - before->second.at_s < kOneLap_s &&
      static_cast<std::int8_t>(frame.sequence - before->second.sequence) <= 0) {
    ++refused_;
    return false;
  }
  numbered_[frame.id] = {frame.sequence, now_s};
  return true;
}

void MavlinkSession::Count(std::uint32_t id) {
  for (Stream& stream : streams_) stream.came += stream.id == id ? 1 : 0;
}

void MavlinkSession::Handle(const Frame& frame, const Message& message, double now_s) {
  if (const auto* m = std::get_if<Heartbeat>(&message)) {
    if (DialectOf(*m) != dialect_ || !InOrder(frame, now_s)) return;
    HandleHeartbeat(*m, now_s);
  } else if (const auto* quaternion = std::get_if<AttitudeQuaternion>(&message)) {
    Count(frame.id);
    if (!std::exchange(by_quaternion_, true)) attitude_ = {};
    if (!Newer(attitude_, quaternion->time_boot_ms, now_s)) return;
    HandleMotion(message, quaternion->time_boot_ms, now_s);
  } else if (const auto* angles = std::get_if<Attitude>(&message)) {
    if (by_quaternion_) return;  // the same once more
    if (!Newer(attitude_, angles->time_boot_ms, now_s)) return;
    HandleMotion(message, angles->time_boot_ms, now_s);
  } else if (const auto* position = std::get_if<LocalPositionNed>(&message)) {
    Count(frame.id);
    if (!Newer(position_, position->time_boot_ms, now_s)) return;
    HandleMotion(message, position->time_boot_ms, now_s);
  } else if (const auto* channels = std::get_if<RcChannels>(&message)) {
    Count(frame.id);
    if (!Newer(channels_, channels->time_boot_ms, now_s)) return;
    rc_ = *channels, rc_s_ = now_s;
  } else if (std::holds_alternative<ExtendedSysState>(message)) {
    Count(frame.id);
    if (!InOrder(frame, now_s)) return;
    telemetry_.Handle(message);
  } else if (const auto* ack = std::get_if<CommandAck>(&message)) {
    TakeAck(*ack, now_s);
  } else if (const auto* timesync = std::get_if<Timesync>(&message)) {
    if (timesync->tc1 == 0) {
      Timesync answer{.tc1 = std::llround(1e9 * now_s), .ts1 = timesync->ts1};
      answer.target_system = target_.system, answer.target_component = target_.component;
      Say(answer);
    } else {
      asked_clock_.Answer(timesync->ts1, timesync->tc1, now_s);
    }
  } else if (const auto* text = std::get_if<Statustext>(&message)) {
    if (text->severity <= kWarning) text_ = Text(text->text);
  } else {
    return;
  }
  ++received_;
}

void MavlinkSession::HandleHeartbeat(const Heartbeat& heartbeat, double now_s) {
  heartbeat_ = heartbeat, heartbeat_s_ = now_s;
  telemetry_.Handle(heartbeat);
  if (InMode()) {
    had_ = true;
    mode_ = {};
  } else if (had_ || (mode_.accepted_s && now_s > *mode_.accepted_s + kAccepted_s)) {
    had_ = false, asks_ = false;  // the pilot took it, or its own fail-safe: not to be overruled
    mode_ = {};
  }
  if (Armed()) arm_ = {};
}

void MavlinkSession::TakeAck(const CommandAck& ack, double now_s) {
  if ((ack.target_system != 0 && ack.target_system != options_.system) ||
      (ack.target_component != 0 && ack.target_component != options_.component))
    return;  // to somebody else's
  Ask* ask = nullptr;
  if (ack.command == kCommandSetMode) ask = &mode_;
  if (ack.command == kCommandArm) ask = &arm_;
  if (ack.command == kCommandTakeOff) ask = &take_off_;
  if (ask == nullptr || !ask->asked_s || ack.result == kInProgress) return;
  if (ack.result == kAccepted) {
    ask->accepted_s = now_s, ask->refused.reset();
  } else {
    ask->refused = ack.result;
  }
}

double MavlinkSession::ToOurs(double their_s, double now_s) const {
  const double heard_s = heard_clock_.ToOurs(their_s).value_or(now_s);
  const std::optional<double> offset = asked_clock_.Offset(now_s);
  return offset && std::abs(their_s + *offset - heard_s) < kOtherClock_s ? their_s + *offset : heard_s;
}

void MavlinkSession::HandleMotion(const Message& message, std::uint32_t time_boot_ms, double now_s) {
  heard_clock_.AddSample(1e-3 * time_boot_ms, now_s);
  if (!telemetry_.Handle(message)) {
    ++refused_;
    return;
  }
  (std::holds_alternative<LocalPositionNed>(message) ? moved_s_ : turned_s_) = now_s;
  const std::optional<VehicleState> state = telemetry_.State(*dialect_);
  if (!state) return;
  // As old as the older of its parts: one that stops, or is refused, is missed at once.
  state_ = *state, state_s_ = std::min(moved_s_, turned_s_);
  state_.t_s = ToOurs(state->t_s, now_s);
  if (!state_.landed) take_off_ = {};
}

bool MavlinkSession::InMode() const {
  return heartbeat_ && heartbeat_->custom_mode == dialect_->setpoint_mode;
}
bool MavlinkSession::Armed() const { return heartbeat_ && (heartbeat_->base_mode & kArmedFlag) != 0; }

bool MavlinkSession::Fresh(double now_s) const {
  return setpoint_ && now_s - setpoint_s_ <= AutopilotLink::kRepeat_s;
}

// A position above the ground on which it stands.
bool MavlinkSession::TakingOff() const {
  const auto* position = setpoint_ ? std::get_if<PositionSetpoint>(&*setpoint_) : nullptr;
  return position != nullptr && state_s_ && state_.landed && position->p_N.z() < state_.p_NB.z() - kClimb_m;
}

bool MavlinkSession::StandsBy() const {
  return options_.stand_by && !asks_ && dialect_->setpoints_first && heartbeat_ && !InMode();
}

void MavlinkSession::Send(const Setpoint& setpoint, double now_s) {
  setpoint_error_.clear();
  const auto* attitude = std::get_if<AttitudeSetpoint>(&setpoint);
  const auto* rates = std::get_if<RateSetpoint>(&setpoint);
  const double thrust = attitude != nullptr ? attitude->thrust : rates != nullptr ? rates->thrust : 0;
  if (!Finite(setpoint)) {
    setpoint_error_ = "setpoint not sent: not finite";
  } else if (!(thrust >= 0 && thrust <= 1)) {
    setpoint_error_ = "setpoint not sent: thrust is not within 0 and 1";
  } else if (attitude != nullptr && !state_s_) {
    setpoint_error_ = "setpoint not sent: an attitude needs the heading, which is not known yet";
  }
  if (!setpoint_error_.empty()) return Silence();
  if (!Fresh(now_s)) streaming_s_ = now_s, yaw_.reset();
  if (attitude == nullptr) yaw_.reset();
  setpoint_ = setpoint, setpoint_s_ = now_s, next_s_ = now_s;
}

void MavlinkSession::Silence() { setpoint_.reset(), streaming_s_.reset(), yaw_.reset(); }

void MavlinkSession::Say(const Message& message) { out_.push_back(sender_.Encode(message)); }

std::vector<wire::Bytes> MavlinkSession::Due(double now_s) {
  if (now_s >= next_heartbeat_s_) {
    next_heartbeat_s_ = now_s + 1;
    Say(CompanionHeartbeat());
  }
  if (setpoint_ && !Fresh(now_s)) Silence();
  if (Open(now_s)) {
    if (now_s >= next_timesync_s_) {
      next_timesync_s_ = now_s + kTimesync_s;
      Say(Timesync{.tc1 = 0, .ts1 = asked_clock_.Ask(now_s)});
    }
    SendSetpoint(now_s);
    AskForControl(now_s);
    AskForStreams(now_s);
    TellSighting();
  }
  sighting_.reset();
  return std::exchange(out_, {});
}

void MavlinkSession::AskForStreams(double now_s) {
  constexpr double kEnough = 0.5;  // of what was asked for
  for (Stream& stream : streams_) {
    const double period_s = stream.asked < kEagerAsks ? kAgain_s : kPatience * kAgain_s;
    const double elapsed_s = now_s - stream.since_s;
    if (elapsed_s < period_s) continue;
    const bool comes = stream.came >= kEnough * stream.rate_hz * elapsed_s;
    stream.since_s = now_s, stream.came = 0;
    if (comes) {
      stream.asked = 0;
      continue;
    }
    ++stream.asked;
    Say(SetMessageInterval(stream.id, stream.rate_hz, target_));
  }
}

void MavlinkSession::AskForControl(double now_s) {
  if (!Fresh(now_s) || PilotAllows(now_s) == false) return;
  const auto say = [this](CommandLong command, Ask& ask) {
    command.confirmation = ask.times++;
    Say(command);
  };
  if (!InMode()) {
    const double lead_s = dialect_->setpoints_first ? kLead_s : 0;
    if (asks_ && now_s - *streaming_s_ >= lead_s && mode_.Due(now_s))
      say(SetCustomMode(dialect_->setpoint_mode, *dialect_, target_), mode_);
    return;
  }
  if (!TakingOff()) return;
  if (!Armed()) {
    if (options_.arm && arm_.Due(now_s)) say(Arm(true, target_), arm_);
    return;
  }
  if (dialect_->takes_off_by_setpoint || !take_off_.Due(now_s)) return;
  const double height_m = state_.p_NB.z() - std::get<PositionSetpoint>(*setpoint_).p_N.z();
  say(TakeOff(height_m, 0, *dialect_, target_), take_off_);
}

void MavlinkSession::SendSetpoint(double now_s) {
  const bool fresh = Fresh(now_s);
  if (now_s < next_s_ || !(fresh || StandsBy())) return;
  // It would break off a take-off that was commanded.
  if (fresh && !dialect_->takes_off_by_setpoint && (TakingOff() || state_.mode == FlightMode::kTakeOff))
    return;
  next_s_ = std::max(next_s_ + (fresh ? 1 / options_.setpoint_hz : kStandBy_s), now_s);
  const Setpoint setpoint = fresh ? *setpoint_ : VelocitySetpoint{};
  if (const auto* attitude = std::get_if<AttitudeSetpoint>(&setpoint)) {
    yaw_ = yaw_ ? WrapAngle(*yaw_ + (now_s - yaw_s_) * attitude->yaw_rate) : YawOf(state_.R_NB);
    yaw_s_ = now_s;
  }
  Say(ToMessage(setpoint, yaw_.value_or(0), *dialect_, target_,
                static_cast<std::uint32_t>(std::llround(1e3 * now_s))));
  if (!fresh) return;
  telemetry_.Sent(setpoint);
  ++sent_;
}

// The autopilot's own pose is that of the exposure, as far as its newest state tells.
void MavlinkSession::TellSighting() {
  constexpr double kOldest_s = 1;
  if (!sighting_ || !state_s_ || !sighting_->p_TB.allFinite() || !sighting_->R_TB.coeffs().allFinite())
    return;
  const double ago_s = std::clamp(state_.t_s - sighting_->t_s, 0.0, kOldest_s);
  const Pose X_NB{state_.R_NB * ExpRotation(-ago_s * state_.w_B), state_.p_NB - ago_s * state_.v_N};
  const bool px4 = dialect_ == &kPx4;
  if (options_.landing_target == "landing_target") Say(ToLandingTarget(*sighting_, X_NB, *dialect_));
  if (options_.landing_target == "target_relative" && px4) Say(ToTargetRelative(*sighting_, X_NB.R));
  if (options_.vision_position == "odometry" && px4) Say(ToOdometry(*sighting_));
  if (options_.vision_position == "vision_position_estimate")
    Say(ToVisionPosition(*sighting_, YawOf(X_NB.R)));
}

std::string MavlinkSession::SightingError() const {
  if (dialect_ != &kArduPilot) return "";
  if (options_.landing_target == "target_relative")
    return "ArduPilot has no TARGET_RELATIVE; valid: mavlink.landing_target=landing_target";
  if (options_.vision_position == "odometry")
    return "ArduPilot takes no ODOMETRY without velocities; valid: "
           "mavlink.vision_position=vision_position_estimate";
  return "";
}

std::optional<bool> MavlinkSession::PilotAllows(double now_s) const {
  if (!Open(now_s)) return std::nullopt;
  if (options_.switch_channel != 0) {
    if (!rc_ || now_s - rc_s_ > kSwitchStale_s) return false;
    const double us = rc_->chan_raw[static_cast<std::size_t>(options_.switch_channel - 1)];
    if (options_.switch_channel > rc_->chancount || us < options_.switch_min_us ||
        us > options_.switch_max_us)
      return false;
  }
  return InMode() || asks_;
}

std::string MavlinkSession::Error(double now_s) const {
  if (!heartbeat_) return stranger_.empty() ? "no autopilot heard" : stranger_;
  if (!Open(now_s)) return "the autopilot is silent";
  if (!state_s_ || now_s - *state_s_ > kStateStale_s) {
    if (!attitude_.time_boot_ms) return "no attitude comes (ATTITUDE_QUATERNION)";
    if (!position_.time_boot_ms) return "no position comes (LOCAL_POSITION_NED)";
    return "attitude or position no longer comes, or cannot be";
  }
  if (!setpoint_error_.empty()) return setpoint_error_;
  if (const std::string error = SightingError(); !error.empty()) return error;
  const auto refused = [this](const Ask& ask, const std::string& what) {
    return what + " refused (MAV_RESULT " + std::to_string(*ask.refused) + ")" +
           (text_.empty() ? "" : ": " + text_);
  };
  if (mode_.refused) return refused(mode_, ModeName(*dialect_));
  if (arm_.refused) return refused(arm_, "arming");
  if (take_off_.refused) return refused(take_off_, "take-off");
  if (!InMode() && !asks_)
    return std::string("not in ") + ModeName(*dialect_) + ": the aircraft is the pilot's";
  if (aid_refused_) return "an attitude alone cannot be told to it";
  return "";
}

LinkHealth MavlinkSession::Health(double now_s) const {
  LinkHealth health;
  health.open = Open(now_s);
  if (state_s_) health.state_age_s = now_s - *state_s_;
  health.pilot_allows = PilotAllows(now_s);
  health.received = received_, health.refused = refused_, health.sent = sent_;
  health.simulated = heartbeat_ && (heartbeat_->base_mode & kSimulatedFlag) != 0;
  health.error = Error(now_s);
  return health;
}

}  // namespace kestrel::control
