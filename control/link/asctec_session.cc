// SPDX-License-Identifier: Apache-2.0
#include "control/link/asctec_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/wire/asctec_units.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using wire::CtrlInput;

constexpr double kSilence_s = 0.02;   // a line that has been silent for so long is idle
constexpr double kPatience_s = 0.03;  // with an answer, beyond what it takes on the line
constexpr double kNoAnswer_s = 0.5;
constexpr double kStatusHolds_s = 1;  // what LL_STATUS and RC_DATA said
constexpr double kGpsHolds_s = 0.25;  // an older one makes no state
constexpr double kFlyBy_s = 0.25;     // by an older state nothing is flown
constexpr double kAnswer_s = 0.1;     // an acknowledgement waits behind a frame and for a late reader
constexpr int kUnanswered = 5;
constexpr double kApart_s = 0.01;  // new setpoints that come faster do not crowd the line
constexpr double kMotors_s = 3;    // of full yaw, at most
constexpr double kTakeOffClimb_m_s = 0.5;
constexpr double kClearOfGround_m = 0.3;
// Full yaw with no thrust starts and stops the motors: in flight the yaw stays clear of it.
constexpr std::int16_t kMaxYawInFlight = 1700;
constexpr std::int16_t kAttitude = wire::kCtrlPitch | wire::kCtrlRoll | wire::kCtrlYaw | wire::kCtrlThrust;
constexpr std::int16_t kSwitchMiddle = 2048;
constexpr std::int32_t kGpsValid = 0x03;

constexpr std::uint16_t kState = wire::ImuCalcData::kRequestBit | wire::GpsDataAdvanced::kRequestBit;

template <class Frame>
std::size_t FrameBytes(std::uint16_t mask) {
  return mask & Frame::kRequestBit ? Frame::kBytes + wire::kTelemetryOverhead : 0;
}
double AnswerTime_s(std::uint16_t mask) {
  return wire::LineTime_s(FrameBytes<wire::ImuCalcData>(mask) + FrameBytes<wire::GpsDataAdvanced>(mask) +
                          FrameBytes<wire::LlStatus>(mask) + FrameBytes<wire::RcData>(mask) +
                          wire::kRequestBytes + wire::kAcknowledgementBytes);
}

CtrlInput MotorSticks() {
  return {.yaw = wire::kStickCounts, .thrust = 0, .ctrl = wire::kCtrlYaw | wire::kCtrlThrust};
}

std::uint64_t Sum(const std::array<std::uint64_t, wire::kLinkRefusals>& counts) {
  std::uint64_t sum = 0;
  for (const auto count : counts) sum += count;
  return sum;
}

}  // namespace

AscTecSession::AscTecSession(const AscTecOptions& options)
    : options_(options), signs_(wire::SignsOf(options.signs)) {}

void AscTecSession::Opened(double now_s) {
  const wire::LinkCounts& counts = parser_.counts();
  earlier_.messages += counts.messages;
  for (std::size_t i = 0; i < wire::kLinkRefusals; ++i) earlier_.refused[i] += counts.refused[i];
  parser_ = {};
  open_ = true;
  opened_s_ = next_cycle_s_ = now_s;
  cycling_ = unread_ = false;
  unanswered_.clear();
  missed_ = 0;
}

void AscTecSession::Closed(const std::string& why) {
  open_ = false;
  closed_why_ = why;
  Rest();
}

void AscTecSession::Receive(double now_s, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  heard_s_ = now_s;
  unread_ = true;
  for (const auto& message : parser_.Feed(bytes)) Handle(now_s, message);
}

void AscTecSession::Handle(double now_s, const wire::Telemetry& message) {
  const auto began_s = [&](std::size_t bytes) {
    return now_s - wire::LineTime_s(bytes + wire::kTelemetryOverhead);
  };
  const auto keep = [&]<class M>(std::optional<Heard<M>>& kept, const M& heard) {
    kept = {heard, began_s(M::kBytes)};
    awaited_ &= static_cast<std::uint16_t>(~M::kRequestBit);
  };
  if (const auto* imu = std::get_if<wire::ImuCalcData>(&message)) {
    keep(imu_, *imu);
    imu_is_new_ = true;
    if (!ground_) ground_ = imu->height;
  } else if (const auto* gps = std::get_if<wire::GpsDataAdvanced>(&message)) {
    keep(gps_, *gps);
  } else if (const auto* status = std::get_if<wire::LlStatus>(&message)) {
    keep(status_, *status);
  } else if (const auto* rc = std::get_if<wire::RcData>(&message)) {
    keep(rc_, *rc);
  } else if (std::holds_alternative<wire::Acknowledgement>(message)) {
    // Whatever it names: which descriptor is unverified, and nothing else is acknowledged.
    if (!unanswered_.empty()) unanswered_.pop_front();
    missed_ = 0;
  }
}

wire::Bytes AscTecSession::Say(double now_s) {
  wire::Bytes bytes;
  if (!open_) return bytes;
  if (unread_ && now_s - *heard_s_ > kSilence_s) {
    unread_ = false;
    for (const auto& message : parser_.Idle()) Handle(now_s, message);
  }
  for (; !unanswered_.empty() && now_s - unanswered_.front() > kAnswer_s; unanswered_.pop_front())
    ++missed_, ++unacknowledged_;
  bool command = false;
  if (cycling_ && (!awaited_ || now_s > cycle_limit_s_)) {
    EndCycle(now_s);
    command = true;
  }
  if (setpoint_is_new_ && now_s - commanded_s_ >= kApart_s) command = true;
  if (command) {
    setpoint_is_new_ = false;
    commanded_s_ = now_s;
    if (const auto input = Command(now_s)) {
      bytes = Encode(wire::Command(*input));
      ++sent_;
      unanswered_.push_back(now_s);
    }
  }
  if (!cycling_ && now_s >= next_cycle_s_) {
    std::uint16_t mask = kState;
    if (cycle_ % 4 == 0) mask |= wire::LlStatus::kRequestBit;
    if (cycle_ % 4 == 2) mask |= wire::RcData::kRequestBit;
    ++cycle_;
    cycling_ = true;
    awaited_ = mask;
    asked_s_ = now_s;
    cycle_limit_s_ = now_s + AnswerTime_s(mask) + kPatience_s;
    next_cycle_s_ = std::max(next_cycle_s_ + options_.cycle_s, now_s);  // what was late is not made up for
    for (const std::uint8_t byte : Encode(wire::Command(wire::Request{mask}))) bytes.push_back(byte);
  }
  return bytes;
}

void AscTecSession::EndCycle(double now_s) {
  cycling_ = false;
  if (awaited_) ++cycles_lost_;
  awaited_ = 0;
  if (imu_is_new_) MakeState(now_s);
  imu_is_new_ = false;
}

void AscTecSession::MakeState(double now_s) {
  const wire::ImuCalcData& imu = imu_->message;
  if (!gps_ || imu_->t_s - gps_->t_s > kGpsHolds_s) return;
  const wire::GpsDataAdvanced& gps = gps_->message;
  if ((gps.gps.status & kGpsValid) != kGpsValid) return;
  const double latitude = gps.latitude_best_estimate * wire::kRadPerLatitudeCount;
  const double longitude = gps.longitude_best_estimate * wire::kRadPerLatitudeCount;
  if (!plane_) plane_.emplace(latitude, longitude, gps.gps.height * wire::kMetresPerCount);

  state_.t_s = imu_->t_s;
  state_.v_N = wire::kMetresPerCount *
               Eigen::Vector3d(gps.speed_y_best_estimate, gps.speed_x_best_estimate, -imu.dheight);
  state_.p_NB.head<2>() = plane_->NorthEast(latitude, longitude) +
                          (imu_->t_s - gps_->t_s) * state_.v_N.head<2>();  // both at one time
  state_.p_NB.z() = -wire::kMetresPerCount * (static_cast<double>(imu.height) - *ground_);
  state_.R_NB = RotationFromTaitBryan({WrapAngle(signs_.angle_yaw * imu.angle_yaw * wire::kRadPerAngleCount),
                                       signs_.angle_nick * imu.angle_nick * wire::kRadPerAngleCount,
                                       signs_.angle_roll * imu.angle_roll * wire::kRadPerAngleCount});
  state_.w_B = wire::kRad_sPerRateCount * Eigen::Vector3d(signs_.angle_roll * double(imu.angvel_roll),
                                                          signs_.angle_nick * double(imu.angvel_nick),
                                                          signs_.angle_yaw * double(imu.angvel_yaw));
  state_.R_NB_inertial = state_.R_NB;
  state_.landed = !InFlight();
  if (state_.landed)
    state_.mode = FlightMode::kStopped;
  else if (motors_ == Motors::kTakingOff)
    state_.mode = FlightMode::kTakeOff;
  else if (!setpoint_)
    state_.mode = FlightMode::kHold;
  else if (std::holds_alternative<VelocitySetpoint>(*setpoint_))
    state_.mode = FlightMode::kVelocity;
  else if (std::holds_alternative<PositionSetpoint>(*setpoint_))
    state_.mode = FlightMode::kPosition;
  else
    state_.mode = FlightMode::kAttitude;
  state_s_ = now_s - std::max(0.0, imu_->t_s - gps_->t_s);  // as old as the older of its parts
}

bool AscTecSession::InFlight() const {
  return status_ && (status_->message.flying != 0 || status_->message.motors_on != 0);
}

std::optional<bool> AscTecSession::PilotAllows(double now_s) const {
  if (!status_ || now_s - status_->t_s > kStatusHolds_s) return std::nullopt;
  const std::int16_t mode = status_->message.flightMode;
  if (!(mode & wire::kFlightModeSerialEnabled) || mode & wire::kFlightModeEmergency) return false;
  if (options_.switch_channel == 0) return true;
  if (!rc_ || now_s - rc_->t_s > kStatusHolds_s) return std::nullopt;
  return rc_->message.channels_in[static_cast<std::size_t>(options_.switch_channel - 1)] > kSwitchMiddle;
}

void AscTecSession::Rest() {
  loop_.t_s.reset();
  touch_ = {};
  motors_ = Motors::kIdle;
  state_.saturated = false;
}

std::optional<CtrlInput> AscTecSession::Command(double now_s) {
  if (setpoint_ && now_s - setpoint_s_ > AutopilotLink::kRepeat_s) setpoint_.reset();
  const bool young = state_s_ && now_s - state_.t_s <= kFlyBy_s;
  if (!setpoint_ || !young || !PilotAllows(now_s).value_or(false)) {
    Rest();
    return std::nullopt;
  }
  const auto become = [&](Motors motors) { motors_ = motors, motors_since_s_ = now_s; };
  if (!options_.motors) return Follow(now_s, *setpoint_);

  if (!InFlight()) {
    const auto* above = std::get_if<PositionSetpoint>(&*setpoint_);
    if (motors_ == Motors::kStarting && now_s - motors_since_s_ > kMotors_s) become(Motors::kRefused);
    if (motors_ == Motors::kRefused) return std::nullopt;
    if (!above || !(above->p_N.z() < state_.p_NB.z() - kClearOfGround_m)) {
      Rest();
      return std::nullopt;
    }
    if (motors_ != Motors::kStarting) become(Motors::kStarting);
    return MotorSticks();
  }
  if (motors_ == Motors::kStarting) {
    become(Motors::kTakingOff);
    take_off_z_ = state_.p_NB.z();
    loop_ = {};
  }
  if (motors_ == Motors::kIdle) become(Motors::kFlying);
  if (motors_ == Motors::kTakingOff) {
    if (take_off_z_ - state_.p_NB.z() > kClearOfGround_m) {
      become(Motors::kFlying);
    } else {
      // No leaning against skids that still stand.
      const auto up = Loop(now_s, {{0, 0, -kTakeOffClimb_m_s}, 0});
      loop_ = up.state;
      loop_.integral_N.head<2>().setZero();
      return Counts({0, 0, 0, up.setpoint.thrust});
    }
  }
  if (motors_ == Motors::kStopping) {
    if (now_s - motors_since_s_ < kMotors_s) return MotorSticks();
    become(Motors::kFlying);  // they turn yet: it may have been a mistake
    touch_ = {};
  }
  const CtrlInput input = Follow(now_s, *setpoint_);
  if (touch_.down) become(Motors::kStopping);
  return touch_.down ? MotorSticks() : input;
}

CtrlInput AscTecSession::Follow(double now_s, const Setpoint& setpoint) {
  if (const auto* attitude = std::get_if<AttitudeSetpoint>(&setpoint)) {
    loop_.t_s.reset(), touch_ = {};
    return Counts(*attitude);
  }
  const auto* position = std::get_if<PositionSetpoint>(&setpoint);
  const VelocitySetpoint wanted = position ? VelocityToward(*position, state_, options_.velocity_loop)
                                           : std::get<VelocitySetpoint>(setpoint);
  return options_.mode == "gps" ? ByGpsMode(wanted) : FollowByAttitude(now_s, wanted);
}

VelocityLoopOutput AscTecSession::Loop(double now_s, const VelocitySetpoint& wanted) const {
  VehicleState now = state_;  // the newest that is known; the loop goes on between two of them
  now.t_s = now_s;
  return StepVelocityLoop(wanted, now, loop_, options_.velocity_loop);
}

CtrlInput AscTecSession::FollowByAttitude(double now_s, const VelocitySetpoint& wanted) {
  const double dt_s = loop_.t_s ? std::clamp(now_s - *loop_.t_s, 0.0, 0.2) : 0.0;
  const VelocityLoopOutput out = Loop(now_s, wanted);
  loop_ = out.state;
  state_.saturated = out.limited;
  touch_ = options_.motors && std::holds_alternative<VelocitySetpoint>(*setpoint_)
               ? WatchTouchDown(dt_s, loop_.reference_N.z(), state_.v_N.z(), touch_)
               : TouchDown{};
  AttitudeSetpoint attitude = out.setpoint;
  attitude.thrust *= touch_.throttle;
  return Counts(attitude);
}

CtrlInput AscTecSession::ByGpsMode(const VelocitySetpoint& wanted) const {
  CtrlInput input;
  // As an attitude would: forward is nose down.
  input.pitch = wire::StickCounts(-signs_.stick_pitch * wanted.v_H.x(), wire::kFullGpsSpeed_m_s);
  input.roll = wire::StickCounts(signs_.stick_roll * wanted.v_H.y(), wire::kFullGpsSpeed_m_s);
  const double turn = Radians(options_.velocity_loop.yaw_rate_limit_deg_s);
  input.yaw = std::clamp(wire::StickCounts(signs_.stick_yaw * std::clamp(wanted.yaw_rate, -turn, turn),
                                           wire::kFullYawRate_rad_s),
                         static_cast<std::int16_t>(-kMaxYawInFlight), kMaxYawInFlight);
  input.thrust = wire::ClimbCounts(-wanted.v_H.z(), options_.full_climb_m_s);
  input.ctrl = kAttitude | wire::kCtrlHeight | wire::kCtrlGps;
  return input;
}

CtrlInput AscTecSession::Counts(const AttitudeSetpoint& wanted) const {
  CtrlInput input;
  input.pitch = wire::StickCounts(signs_.stick_pitch * wanted.pitch, wire::kFullTilt_rad);
  input.roll = wire::StickCounts(signs_.stick_roll * wanted.roll, wire::kFullTilt_rad);
  input.yaw = std::clamp(wire::StickCounts(signs_.stick_yaw * wanted.yaw_rate, wire::kFullYawRate_rad_s),
                         static_cast<std::int16_t>(-kMaxYawInFlight), kMaxYawInFlight);
  input.thrust = wire::ThrustCounts(wanted.thrust);
  input.ctrl = kAttitude;
  return input;
}

void AscTecSession::Send(double now_s, const Setpoint& setpoint) {
  if (!Finite(setpoint)) {
    refused_ = "a setpoint that is not finite was not sent";
    return;
  }
  if (std::holds_alternative<RateSetpoint>(setpoint)) {
    refused_ = "AscTec's processor takes no RateSetpoint: not sent";
    return Silence();  // nor what was asked for before
  }
  refused_.clear();
  setpoint_ = setpoint;
  setpoint_s_ = now_s;
  setpoint_is_new_ = true;
}

void AscTecSession::Aid() { aid_asked_ = true; }

void AscTecSession::Silence() {
  setpoint_.reset();
  Rest();
}

LinkHealth AscTecSession::Health(double now_s) const {
  LinkHealth health;
  health.open = open_;
  if (state_s_) health.state_age_s = now_s - *state_s_;
  health.pilot_allows = PilotAllows(now_s);
  health.received = earlier_.messages + parser_.counts().messages;
  health.refused = Sum(earlier_.refused) + Sum(parser_.counts().refused);
  health.sent = sent_;
  const auto battery_v = [&] { return status_->message.battery_voltage_1 * 1e-3; };
  if (!open_)
    health.error = closed_why_;
  else if (now_s - std::max(heard_s_.value_or(opened_s_), opened_s_) > kNoAnswer_s)
    health.error = "the processor does not answer";
  else if (status_ && status_->message.flightMode & wire::kFlightModeEmergency)
    health.error = "emergency: the processor has lost its R/C";
  else if (status_ && battery_v() < options_.battery_v)
    health.error =
        fmt::format("the battery has {:.1f} V, less than {:.1f} V", battery_v(), options_.battery_v);
  else if (gps_ && (gps_->message.gps.status & kGpsValid) != kGpsValid)
    health.error = "no GPS fix";
  else if (motors_ == Motors::kRefused)
    health.error = "the motors do not start when asked to";
  else if (missed_ >= kUnanswered)
    health.error = "setpoints are not acknowledged";
  else if (aid_asked_)
    health.error = "the processor takes no attitude from outside";
  else
    health.error = refused_;
  return health;
}

}  // namespace kestrel::control
