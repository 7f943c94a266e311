// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink_dialects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "geometry/tait_bryan.h"

namespace kestrel::control::wire::mavlink {
namespace {

// MAV_FRAME
constexpr std::uint8_t kLocalNed = 1, kBodyNed = 8, kBodyFrd = 12;
// POSITION_TARGET_TYPEMASK: what to leave out
constexpr std::uint16_t kNoPosition = 1 | 2 | 4, kNoVelocity = 8 | 16 | 32, kNoAcceleration = 64 | 128 | 256;
constexpr std::uint16_t kNoYaw = 1024, kNoYawRate = 2048;
// ATTITUDE_TARGET_TYPEMASK
constexpr std::uint8_t kNoRollRate = 1, kNoPitchRate = 2, kNoAttitude = 128;
// MAV_CMD
constexpr std::uint16_t kTakeOff = 22, kDoSetMode = 176, kArmDisarm = 400, kSetMessageInterval = 511;
// MAV_MODE_FLAG
constexpr std::uint8_t kCustomModeEnabled = 1, kArmed = 128;
// MAV_LANDED_STATE
constexpr std::uint8_t kUndefined = 0, kOnGround = 1, kTakingOff = 3;

constexpr double kLongestSpread_s = 0.5;

float Float(double value) { return static_cast<float>(value); }

CommandLong Command(std::uint16_t command, Target target) {
  CommandLong message;
  message.command = command, message.target_system = target.system;
  message.target_component = target.component;
  return message;
}

SetPositionTargetLocalNed PositionTarget(Target target, std::uint32_t time_boot_ms) {
  SetPositionTargetLocalNed message;
  message.time_boot_ms = time_boot_ms;
  message.target_system = target.system, message.target_component = target.component;
  return message;
}

}  // namespace

const Dialect* DialectOf(const Heartbeat& heartbeat) {
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    if (heartbeat.autopilot == dialect->autopilot) return dialect;
  }
  return nullptr;
}

Heartbeat CompanionHeartbeat() {
  constexpr std::uint8_t kOnboardController = 18, kNoAutopilot = 8, kActive = 4;
  return {.type = kOnboardController, .autopilot = kNoAutopilot, .system_status = kActive};
}

FlightMode ModeFor(const Setpoint& setpoint) {
  if (std::holds_alternative<VelocitySetpoint>(setpoint)) return FlightMode::kVelocity;
  if (std::holds_alternative<PositionSetpoint>(setpoint)) return FlightMode::kPosition;
  if (std::holds_alternative<RateSetpoint>(setpoint)) return FlightMode::kRates;
  return FlightMode::kAttitude;
}

Message ToMessage(const Setpoint& setpoint, double yaw, const Dialect& dialect, Target target,
                  std::uint32_t time_boot_ms) {
  if (const auto* velocity = std::get_if<VelocitySetpoint>(&setpoint)) {
    SetPositionTargetLocalNed message = PositionTarget(target, time_boot_ms);
    message.coordinate_frame = kBodyNed;
    message.type_mask = kNoPosition | kNoAcceleration | kNoYaw;
    message.vx = Float(velocity->v_H.x()), message.vy = Float(velocity->v_H.y());
    message.vz = Float(velocity->v_H.z()), message.yaw_rate = Float(velocity->yaw_rate);
    return message;
  }
  if (const auto* position = std::get_if<PositionSetpoint>(&setpoint)) {
    SetPositionTargetLocalNed message = PositionTarget(target, time_boot_ms);
    message.coordinate_frame = kLocalNed;
    message.type_mask = kNoVelocity | kNoAcceleration | kNoYawRate;
    message.x = Float(position->p_N.x()), message.y = Float(position->p_N.y());
    message.z = Float(position->p_N.z()), message.yaw = Float(position->yaw);
    return message;
  }
  if (const auto* rates = std::get_if<RateSetpoint>(&setpoint)) {
    SetAttitudeTarget message;
    message.time_boot_ms = time_boot_ms;
    message.target_system = target.system, message.target_component = target.component;
    message.type_mask = kNoAttitude;
    message.q = {1, 0, 0, 0};
    message.body_roll_rate = Float(rates->w_B.x()), message.body_pitch_rate = Float(rates->w_B.y());
    message.body_yaw_rate = Float(rates->w_B.z()), message.thrust = Float(rates->thrust);
    return message;
  }
  const auto& attitude = std::get<AttitudeSetpoint>(setpoint);
  const Eigen::Quaterniond R_NB(
      RotationFromTaitBryan({.yaw = yaw, .pitch = attitude.pitch, .roll = attitude.roll}));
  SetAttitudeTarget message;
  message.time_boot_ms = time_boot_ms;
  message.target_system = target.system, message.target_component = target.component;
  message.q = {Float(R_NB.w()), Float(R_NB.x()), Float(R_NB.y()), Float(R_NB.z())};
  message.thrust = Float(attitude.thrust);
  if (&dialect == &kPx4) {  // the yaw rate about the vertical; the two others would be followed in place of q
    message.type_mask = kNoRollRate | kNoPitchRate;
    message.body_yaw_rate = Float(attitude.yaw_rate);
  } else {  // all three rates in B, or none
    const Eigen::Vector3d w_B = R_NB.conjugate() * Eigen::Vector3d(0, 0, attitude.yaw_rate);
    message.body_roll_rate = Float(w_B.x()), message.body_pitch_rate = Float(w_B.y());
    message.body_yaw_rate = Float(w_B.z());
  }
  return message;
}

CommandLong Arm(bool armed, Target target) {
  CommandLong message = Command(kArmDisarm, target);
  message.param1 = armed ? 1 : 0;
  return message;
}

CommandLong SetCustomMode(std::uint32_t custom_mode, const Dialect& dialect, Target target) {
  CommandLong message = Command(kDoSetMode, target);
  message.param1 = kCustomModeEnabled;
  if (&dialect == &kPx4) {  // its main and sub mode apart
    message.param2 = static_cast<float>(custom_mode >> 16 & 0xFF);
    message.param3 = static_cast<float>(custom_mode >> 24 & 0xFF);
  } else {
    message.param2 = static_cast<float>(custom_mode);
  }
  return message;
}

CommandLong TakeOff(double height_m, double altitude_m, const Dialect& dialect, Target target) {
  constexpr float kHere = std::numeric_limits<float>::quiet_NaN();
  CommandLong message = Command(kTakeOff, target);
  message.param7 = Float(height_m);
  if (&dialect == &kPx4) {
    message.param4 = message.param5 = message.param6 = kHere;  // yaw, latitude, longitude
    message.param7 = Float(altitude_m + height_m);
  }
  return message;
}

CommandLong SetMessageInterval(std::uint32_t id, double rate_hz, Target target) {
  CommandLong message = Command(kSetMessageInterval, target);
  message.param1 = static_cast<float>(id);
  message.param2 = Float(1e6 / rate_hz);
  return message;
}

LandingTarget ToLandingTarget(const Eigen::Vector3d& p_NT, const Pose& X_NB, const Dialect& dialect,
                              std::uint64_t time_usec) {
  constexpr std::uint8_t kFiducial = 2;
  const Eigen::Vector3d p_BT = X_NB.Inverse() * p_NT;
  const bool in_world = &dialect == &kPx4;
  const Eigen::Vector3d p = in_world ? p_NT : p_BT;
  LandingTarget message;
  message.time_usec = time_usec;
  message.distance = Float(p_BT.norm());
  message.frame = in_world ? kLocalNed : kBodyFrd;
  message.x = Float(p.x()), message.y = Float(p.y()), message.z = Float(p.z());
  message.q = {1, 0, 0, 0};
  message.type = kFiducial;
  message.position_valid = 1;
  return message;
}

bool Telemetry::Note(const Turning& turning) {
  VehicleState alone;
  alone.R_NB = turning.R_NB, alone.w_B = turning.w_B;
  if (!Sane(alone)) return false;
  turning_ = turning;
  turning_->R_NB.normalize();
  return true;
}

bool Telemetry::Handle(const Message& message) {
  if (const auto* m = std::get_if<Heartbeat>(&message)) {
    heartbeat_ = *m;
    return true;
  }
  if (const auto* m = std::get_if<ExtendedSysState>(&message)) {
    landed_state_ = m->landed_state;
    return true;
  }
  if (const auto* m = std::get_if<Attitude>(&message)) {
    for (const float angle : {m->roll, m->pitch, m->yaw})
      if (!(std::abs(angle) <= 2 * M_PI)) return false;
    return Note(
        {1e-3 * m->time_boot_ms,
         Eigen::Quaterniond(RotationFromTaitBryan({.yaw = m->yaw, .pitch = m->pitch, .roll = m->roll})),
         Eigen::Vector3f(m->rollspeed, m->pitchspeed, m->yawspeed).cast<double>()});
  }
  if (const auto* m = std::get_if<AttitudeQuaternion>(&message)) {
    return Note({1e-3 * m->time_boot_ms, Eigen::Quaterniond(m->q1, m->q2, m->q3, m->q4),
                 Eigen::Vector3f(m->rollspeed, m->pitchspeed, m->yawspeed).cast<double>()});
  }
  if (const auto* m = std::get_if<LocalPositionNed>(&message)) {
    VehicleState alone;
    alone.p_NB = {m->x, m->y, m->z}, alone.v_N = {m->vx, m->vy, m->vz};
    if (!Sane(alone)) return false;
    moving_ = {1e-3 * m->time_boot_ms, {m->x, m->y, m->z}, {m->vx, m->vy, m->vz}};
    return true;
  }
  return false;
}

std::optional<VehicleState> Telemetry::State(const Dialect& dialect) const {
  if (!heartbeat_ || !turning_ || !moving_) return std::nullopt;
  if (std::abs(turning_->t_s - moving_->t_s) > kLongestSpread_s) return std::nullopt;
  VehicleState state;
  state.t_s = std::max(turning_->t_s, moving_->t_s);
  state.p_NB = moving_->p_NB + (state.t_s - moving_->t_s) * moving_->v_N;
  state.v_N = moving_->v_N;
  state.R_NB = turning_->R_NB * ExpRotation((state.t_s - turning_->t_s) * turning_->w_B);
  state.w_B = turning_->w_B;
  state.R_NB_inertial = state.R_NB;
  const bool armed = (heartbeat_->base_mode & kArmed) != 0;
  const std::uint8_t landed = landed_state_.value_or(kUndefined);
  state.landed = landed == kUndefined ? !armed : landed == kOnGround;
  if (!armed) {
    state.mode = FlightMode::kStopped;
  } else if (landed == kTakingOff) {
    state.mode = FlightMode::kTakeOff;
  } else {
    state.mode = heartbeat_->custom_mode == dialect.setpoint_mode ? sent_ : FlightMode::kHold;
  }
  return state;
}

}  // namespace kestrel::control::wire::mavlink
