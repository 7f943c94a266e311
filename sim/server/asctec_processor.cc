// SPDX-License-Identifier: Apache-2.0
#include "sim/server/asctec_processor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "control/wire/asctec_units.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kQuiet_s = 0.02;
constexpr double kSticks_s = 0.3;  // that start and stop the motors
constexpr double kSticksLetGo_s = 0.3;
constexpr std::int16_t kFullYaw = 1900;  // and above
constexpr std::int16_t kTakeOffThrust = kestrel::control::wire::kThrustCounts * 3 / 10;
constexpr double kTakeOff_m = 0.5;
constexpr double kSinkToStop_m_s = 0.2;
constexpr std::int16_t kAttitudeSticks = control::wire::kCtrlPitch | control::wire::kCtrlRoll |
                                         control::wire::kCtrlYaw | control::wire::kCtrlThrust;
constexpr std::int16_t kGps = control::wire::kCtrlHeight | control::wire::kCtrlGps;

std::int32_t ToCounts(double value, double unit) {
  const double counts = std::round(value / unit);
  return std::abs(counts) < 2e9 ? static_cast<std::int32_t>(counts) : 0;
}

// Thrust 0 and full yaw: these start and stop them.
bool MoveTheMotors(const control::wire::CtrlInput& input) {
  return (input.ctrl & control::wire::kCtrlThrust) && (input.ctrl & control::wire::kCtrlYaw) &&
         input.thrust == 0 && std::abs(input.yaw) >= kFullYaw;
}

}  // namespace

void SerialLine::Put(double now_s, std::span<const std::uint8_t> bytes) {
  free_s_ = std::max(free_s_, now_s);
  for (const std::uint8_t byte : bytes) {
    bytes_.push_back(byte);
    if (bytes_.size() > kMax)
      bytes_.pop_front();  // and its turn is the next one's
    else
      arrive_s_.push_back(free_s_ += control::wire::LineTime_s(1));
  }
}

control::wire::Bytes SerialLine::Receive(double now_s) {
  control::wire::Bytes arrived;
  for (; !bytes_.empty() && arrive_s_.front() <= now_s; bytes_.pop_front(), arrive_s_.pop_front())
    arrived.push_back(bytes_.front());
  return arrived;
}

AscTecProcessor::AscTecProcessor(const AscTecProcessorOptions& options)
    : options_(options), signs_(control::wire::SignsOf(options.signs)) {}

void AscTecProcessor::Receive(double now_s, std::span<const std::uint8_t> bytes) {
  received_.Put(now_s, bytes);
}

control::wire::Bytes AscTecProcessor::Step(double now_s, control::Autopilot& aircraft) {
  const control::wire::Bytes arrived = received_.Receive(now_s);
  std::vector<control::wire::Command> commands;
  if (!arrived.empty()) {
    quiet_since_s_ = now_s;
    commands = parser_.Feed(arrived);
  } else if (quiet_since_s_ && now_s - *quiet_since_s_ > kQuiet_s) {
    quiet_since_s_.reset();
    commands = parser_.Idle();
  }
  for (const control::wire::Command& command : commands) {
    if (const auto* request = std::get_if<control::wire::Request>(&command)) {
      if (!asked_) asked_s_ = now_s;
      asked_ |= request->mask;
    } else if (const auto* input = std::get_if<control::wire::CtrlInput>(&command)) {
      sent_.Put(now_s, Encode(control::wire::Telemetry(
                           control::wire::Acknowledgement{control::wire::CtrlInput::kDescriptor})));
      CountSetpoint(*input);
      if (pilot_allows_) Obey(now_s, *input, aircraft);
    }
  }
  const auto& refused = parser_.counts().refused;
  const std::uint64_t damaged = std::accumulate(refused.begin(), refused.end(), std::uint64_t{0});
  counts_.CountIgnored(ignored::kDamaged, "a frame with a wrong check sum, length or kind",
                       damaged - damaged_);
  damaged_ = damaged;
  Speak(now_s, aircraft);
  return sent_.Receive(now_s);
}

void AscTecProcessor::CountSetpoint(const control::wire::CtrlInput& input) {
  const bool sticks = MoveTheMotors(input);
  if (!sticks && (input.ctrl & kAttitudeSticks) != kAttitudeSticks) {
    ++counts_.refused;
    counts_.CountIgnored(ignored::kImpossible, fmt::format("CTRL_INPUT with ctrl 0x{:x}", input.ctrl));
    return;
  }
  ++counts_.setpoints;
  if (pilot_allows_)
    ++counts_.followed;
  else
    counts_.CountIgnored(ignored::kPilot, "CTRL_INPUT");
}

void AscTecProcessor::Speak(double now_s, control::Autopilot& aircraft) {
  // A caller that comes late finds more than one begun: without gaps, as the line would have sent them.
  while (asked_ && std::max(sent_.free_s(), asked_s_) <= now_s) {
    const double begins_s = std::max(sent_.free_s(), asked_s_);
    sent_.Put(begins_s, NextFrame(now_s, aircraft.State()));
  }
}

control::wire::Bytes AscTecProcessor::NextFrame(double now_s, const control::VehicleState& state) {
  const auto taken = [&]<class M>(const M&) {
    if (!(asked_ & M::kRequestBit)) return false;
    asked_ &= static_cast<std::uint16_t>(~M::kRequestBit);
    return true;
  };
  const auto frame = [](const control::wire::Telemetry& message) { return Encode(message); };
  if (taken(control::wire::LlStatus{})) return frame(Status(now_s, state));
  if (taken(control::wire::ImuRawData{})) return frame(control::wire::ImuRawData{});
  if (taken(control::wire::ImuCalcData{})) return frame(Imu(state));
  if (taken(control::wire::RcData{})) return frame(Radio());
  if (taken(control::wire::CtrlOut{})) return frame(control::wire::CtrlOut{});
  if (taken(control::wire::GpsData{})) return frame(Gps(state).gps);
  if (taken(control::wire::GpsDataAdvanced{})) return frame(Gps(state));
  asked_ = 0;  // the way-point and the camera, which it does not have
  return {};
}

void AscTecProcessor::Obey(double now_s, const control::wire::CtrlInput& input,
                           control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  const bool first = !commanded_s_ || now_s - *commanded_s_ > kSticksLetGo_s;
  commanded_s_ = now_s;
  const bool sticks = MoveTheMotors(input);
  if (!sticks || first) sticks_since_s_.reset(), sticks_done_ = false;
  if (sticks) {
    if (!sticks_since_s_) sticks_since_s_ = now_s;
    const bool held = now_s - *sticks_since_s_ >= kSticks_s;
    if (!state.landed) {
      if (held)
        aircraft.Send(control::VelocitySetpoint{{0, 0, kSinkToStop_m_s}, 0});
      else
        aircraft.Send(control::AttitudeSetpoint{});
    } else if (held && !sticks_done_) {
      idling_ = !idling_;
    }
    sticks_done_ = held;
    return;
  }
  if ((input.ctrl & kAttitudeSticks) != kAttitudeSticks) return;
  if (state.landed) {
    if (idling_ && input.thrust > kTakeOffThrust)
      aircraft.Send(
          control::PositionSetpoint{state.p_NB - Eigen::Vector3d(0, 0, kTakeOff_m), YawOf(state.R_NB)});
    return;
  }
  idling_ = false;  // it flies: they stop with its touch-down
  const double yaw_rate =
      signs_.stick_yaw * control::wire::FromStickCounts(input.yaw, control::wire::kFullYawRate_rad_s);
  by_gps_ = options_.gps_mode && (input.ctrl & kGps) == kGps;
  if (by_gps_) {
    const auto speed = [](std::int16_t counts) {
      return control::wire::FromStickCounts(counts, control::wire::kFullGpsSpeed_m_s);
    };
    const double climb_m_s =
        options_.full_climb_m_s * (input.thrust - control::wire::kStickCounts) / control::wire::kStickCounts;
    aircraft.Send(control::VelocitySetpoint{
        {-signs_.stick_pitch * speed(input.pitch), signs_.stick_roll * speed(input.roll), -climb_m_s},
        yaw_rate});
  } else {
    const auto angle = [](std::int16_t counts) {
      return control::wire::FromStickCounts(counts, control::wire::kFullTilt_rad);
    };
    aircraft.Send(control::AttitudeSetpoint{signs_.stick_roll * angle(input.roll),
                                            signs_.stick_pitch * angle(input.pitch), yaw_rate,
                                            control::wire::FromThrustCounts(input.thrust)});
  }
}

control::wire::LlStatus AscTecProcessor::Status(double now_s, const control::VehicleState& state) const {
  control::wire::LlStatus s;
  s.battery_voltage_1 = static_cast<std::int16_t>(std::lround(options_.battery_v * 1000));
  s.cpu_load = 1000;
  s.compass_enabled = 1;
  s.flying = s.motors_on = !state.landed || idling_;
  s.flightMode = control::wire::kFlightModeAcc;
  if (by_gps_) s.flightMode |= control::wire::kFlightModeHeight | control::wire::kFlightModeGps;
  if (pilot_allows_) {
    s.flightMode |= control::wire::kFlightModeSerialEnabled;
    if (commanded_s_ && now_s - *commanded_s_ < options_.command_timeout_s)
      s.flightMode |= control::wire::kFlightModeSerialActive;
  }
  return s;
}

control::wire::ImuCalcData AscTecProcessor::Imu(const control::VehicleState& state) const {
  const TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  control::wire::ImuCalcData d;
  const auto angle = [](double rad) { return ToCounts(rad, control::wire::kRadPerAngleCount); };
  d.angle_nick = d.acc_angle_nick = signs_.angle_nick * angle(angles.pitch);
  d.angle_roll = d.acc_angle_roll = signs_.angle_roll * angle(angles.roll);
  d.angle_yaw = signs_.angle_yaw * angle(angles.yaw);
  if (d.angle_yaw < 0) d.angle_yaw += 360000;
  d.mag_heading = d.angle_yaw;
  d.angvel_roll = signs_.angle_roll * ToCounts(state.w_B.x(), control::wire::kRad_sPerRateCount);
  d.angvel_nick = signs_.angle_nick * ToCounts(state.w_B.y(), control::wire::kRad_sPerRateCount);
  d.angvel_yaw = signs_.angle_yaw * ToCounts(state.w_B.z(), control::wire::kRad_sPerRateCount);
  d.acc_absolute_value = 10000;
  d.acc_z = d.acc_z_calib = -10000;
  d.height = d.height_reference = ToCounts(-state.p_NB.z(), control::wire::kMetresPerCount);
  d.dheight = d.dheight_reference = ToCounts(-state.v_N.z(), control::wire::kMetresPerCount);
  return d;
}

control::wire::GpsDataAdvanced AscTecProcessor::Gps(const control::VehicleState& state) const {
  const GeodeticPosition place = GeodeticOf(options_.origin, state.p_NB);
  control::wire::GpsDataAdvanced d;
  d.latitude_best_estimate = d.gps.latitude =
      ToCounts(Radians(place.latitude_deg), control::wire::kRadPerLatitudeCount);
  d.longitude_best_estimate = d.gps.longitude =
      ToCounts(Radians(place.longitude_deg), control::wire::kRadPerLatitudeCount);
  d.speed_x_best_estimate = d.gps.speed_x = ToCounts(state.v_N.y(), control::wire::kMetresPerCount);
  d.speed_y_best_estimate = d.gps.speed_y = ToCounts(state.v_N.x(), control::wire::kMetresPerCount);
  d.gps.height = ToCounts(place.altitude_m, control::wire::kMetresPerCount);
  const double course = std::atan2(state.v_N.y(), state.v_N.x());
  d.gps.heading =
      ToCounts(course < 0 ? course + 2 * std::numbers::pi : course, control::wire::kRadPerAngleCount);
  d.gps.horizontal_accuracy = 2000, d.gps.vertical_accuracy = 3000, d.gps.speed_accuracy = 300;
  d.gps.numSV = 10;
  d.gps.status = 0x03;
  return d;
}

control::wire::RcData AscTecProcessor::Radio() const {
  control::wire::RcData d;
  d.channels_in.fill(2048);
  d.channels_in[4] = pilot_allows_ ? 4095 : 0;
  d.channels_out = d.channels_in;
  d.lock = 1;
  return d;
}

}  // namespace kestrel::sim
