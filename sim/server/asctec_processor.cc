// SPDX-License-Identifier: Apache-2.0
#include "sim/server/asctec_processor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "control/wire/asctec_units.h"
#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

constexpr double kQuiet_s = 0.02;
constexpr double kSticks_s = 0.3;  // that start and stop the motors
constexpr double kSticksLetGo_s = 0.3;
constexpr std::int16_t kFullYaw = 1900;  // and above
constexpr std::int16_t kTakeOffThrust = kestrel::wire::kThrustCounts * 3 / 10;
constexpr double kTakeOff_m = 0.5;
constexpr double kSinkToStop_m_s = 0.2;
constexpr std::int16_t kAttitude = wire::kCtrlPitch | wire::kCtrlRoll | wire::kCtrlYaw | wire::kCtrlThrust;
constexpr std::int16_t kGps = wire::kCtrlHeight | wire::kCtrlGps;

std::int32_t Counts(double value, double unit) {
  const double counts = std::round(value / unit);
  return std::abs(counts) < 2e9 ? static_cast<std::int32_t>(counts) : 0;
}

// Thrust 0 and full yaw: these start and stop them.
bool MoveTheMotors(const wire::CtrlInput& input) {
  return (input.ctrl & wire::kCtrlThrust) && (input.ctrl & wire::kCtrlYaw) && input.thrust == 0 &&
         std::abs(input.yaw) >= kFullYaw;
}

}  // namespace

void SerialLine::Put(double now_s, std::span<const std::uint8_t> bytes) {
  free_s_ = std::max(free_s_, now_s);
  for (const std::uint8_t byte : bytes) {
    bytes_.push_back(byte);
    if (bytes_.size() > kMost)
      bytes_.pop_front();  // and its turn is the next one's
    else
      arrive_s_.push_back(free_s_ += wire::LineTime_s(1));
  }
}

wire::Bytes SerialLine::Take(double now_s) {
  wire::Bytes arrived;
  for (; !bytes_.empty() && arrive_s_.front() <= now_s; bytes_.pop_front(), arrive_s_.pop_front())
    arrived.push_back(bytes_.front());
  return arrived;
}

AscTecProcessor::AscTecProcessor(const AscTecProcessorOptions& options)
    : options_(options), signs_(wire::SignsOf(options.signs)) {}

void AscTecProcessor::Hear(double now_s, std::span<const std::uint8_t> bytes) { heard_.Put(now_s, bytes); }

wire::Bytes AscTecProcessor::Step(double now_s, Autopilot& aircraft) {
  const wire::Bytes arrived = heard_.Take(now_s);
  std::vector<wire::Command> commands;
  if (!arrived.empty()) {
    quiet_since_s_ = now_s;
    commands = parser_.Feed(arrived);
  } else if (quiet_since_s_ && now_s - *quiet_since_s_ > kQuiet_s) {
    quiet_since_s_.reset();
    commands = parser_.Idle();
  }
  for (const wire::Command& command : commands) {
    if (const auto* request = std::get_if<wire::Request>(&command)) {
      if (!asked_) asked_s_ = now_s;
      asked_ |= request->mask;
    } else if (const auto* input = std::get_if<wire::CtrlInput>(&command)) {
      said_.Put(now_s, Encode(wire::Telemetry(wire::Acknowledgement{wire::CtrlInput::kDescriptor})));
      CountSetpoint(*input);
      if (pilot_allows_) Obey(now_s, *input, aircraft);
    }
  }
  const auto& refused = parser_.counts().refused;
  const std::uint64_t damaged = std::accumulate(refused.begin(), refused.end(), std::uint64_t{0});
  counts_.NotHeeded(unheeded::kDamaged, "a frame with a wrong check sum, length or kind", damaged - damaged_);
  damaged_ = damaged;
  Speak(now_s, aircraft);
  return said_.Take(now_s);
}

void AscTecProcessor::CountSetpoint(const wire::CtrlInput& input) {
  const bool sticks = MoveTheMotors(input);
  if (!sticks && (input.ctrl & kAttitude) != kAttitude) {
    ++counts_.refused;
    counts_.NotHeeded(unheeded::kImpossible, fmt::format("CTRL_INPUT with ctrl 0x{:x}", input.ctrl));
    return;
  }
  ++counts_.setpoints;
  if (pilot_allows_)
    ++counts_.followed;
  else
    counts_.NotHeeded(unheeded::kPilot, "CTRL_INPUT");
}

void AscTecProcessor::Speak(double now_s, Autopilot& aircraft) {
  // A caller that comes late finds more than one begun: without gaps, as the line would have sent them.
  while (asked_ && std::max(said_.free_s(), asked_s_) <= now_s) {
    const double begins_s = std::max(said_.free_s(), asked_s_);
    said_.Put(begins_s, NextFrame(now_s, aircraft.State()));
  }
}

wire::Bytes AscTecProcessor::NextFrame(double now_s, const VehicleState& state) {
  const auto taken = [&]<class M>(const M&) {
    if (!(asked_ & M::kRequestBit)) return false;
    asked_ &= static_cast<std::uint16_t>(~M::kRequestBit);
    return true;
  };
  const auto frame = [](const wire::Telemetry& message) { return Encode(message); };
  if (taken(wire::LlStatus{})) return frame(Status(now_s, state));
  if (taken(wire::ImuRawData{})) return frame(wire::ImuRawData{});
  if (taken(wire::ImuCalcData{})) return frame(Imu(state));
  if (taken(wire::RcData{})) return frame(Radio());
  if (taken(wire::CtrlOut{})) return frame(wire::CtrlOut{});
  if (taken(wire::GpsData{})) return frame(Gps(state).gps);
  if (taken(wire::GpsDataAdvanced{})) return frame(Gps(state));
  asked_ = 0;  // the way-point and the camera, which it does not have
  return {};
}

void AscTecProcessor::Obey(double now_s, const wire::CtrlInput& input, Autopilot& aircraft) {
  const VehicleState state = aircraft.State();
  const bool first = !commanded_s_ || now_s - *commanded_s_ > kSticksLetGo_s;
  commanded_s_ = now_s;
  const bool sticks = MoveTheMotors(input);
  if (!sticks || first) sticks_since_s_.reset(), sticks_done_ = false;
  if (sticks) {
    if (!sticks_since_s_) sticks_since_s_ = now_s;
    const bool held = now_s - *sticks_since_s_ >= kSticks_s;
    if (!state.landed) {
      if (held)
        aircraft.Send(VelocitySetpoint{{0, 0, kSinkToStop_m_s}, 0});
      else
        aircraft.Send(AttitudeSetpoint{});
    } else if (held && !sticks_done_) {
      idling_ = !idling_;
    }
    sticks_done_ = held;
    return;
  }
  if ((input.ctrl & kAttitude) != kAttitude) return;
  if (state.landed) {
    if (idling_ && input.thrust > kTakeOffThrust)
      aircraft.Send(PositionSetpoint{state.p_NB - Eigen::Vector3d(0, 0, kTakeOff_m), YawOf(state.R_NB)});
    return;
  }
  idling_ = false;  // it flies: they stop with its touch-down
  const double yaw_rate = signs_.stick_yaw * wire::FromStickCounts(input.yaw, wire::kFullYawRate_rad_s);
  by_gps_ = options_.gps_mode && (input.ctrl & kGps) == kGps;
  if (by_gps_) {
    const auto speed = [](std::int16_t counts) {
      return wire::FromStickCounts(counts, wire::kFullGpsSpeed_m_s);
    };
    const double climb_m_s =
        options_.full_climb_m_s * (input.thrust - wire::kStickCounts) / wire::kStickCounts;
    aircraft.Send(VelocitySetpoint{
        {-signs_.stick_pitch * speed(input.pitch), signs_.stick_roll * speed(input.roll), -climb_m_s},
        yaw_rate});
  } else {
    const auto angle = [](std::int16_t counts) { return wire::FromStickCounts(counts, wire::kFullTilt_rad); };
    aircraft.Send(AttitudeSetpoint{signs_.stick_roll * angle(input.roll),
                                   signs_.stick_pitch * angle(input.pitch), yaw_rate,
                                   wire::FromThrustCounts(input.thrust)});
  }
}

wire::LlStatus AscTecProcessor::Status(double now_s, const VehicleState& state) const {
  wire::LlStatus s;
  s.battery_voltage_1 = static_cast<std::int16_t>(std::lround(options_.battery_v * 1000));
  s.cpu_load = 1000;
  s.compass_enabled = 1;
  s.flying = s.motors_on = !state.landed || idling_;
  s.flightMode = wire::kFlightModeAcc;
  if (by_gps_) s.flightMode |= wire::kFlightModeHeight | wire::kFlightModeGps;
  if (pilot_allows_) {
    s.flightMode |= wire::kFlightModeSerialEnabled;
    if (commanded_s_ && now_s - *commanded_s_ < options_.command_timeout_s)
      s.flightMode |= wire::kFlightModeSerialActive;
  }
  return s;
}

wire::ImuCalcData AscTecProcessor::Imu(const VehicleState& state) const {
  const TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  wire::ImuCalcData d;
  const auto angle = [](double rad) { return Counts(rad, wire::kRadPerAngleCount); };
  d.angle_nick = d.acc_angle_nick = signs_.angle_nick * angle(angles.pitch);
  d.angle_roll = d.acc_angle_roll = signs_.angle_roll * angle(angles.roll);
  d.angle_yaw = signs_.angle_yaw * angle(angles.yaw);
  if (d.angle_yaw < 0) d.angle_yaw += 360000;
  d.mag_heading = d.angle_yaw;
  d.angvel_roll = signs_.angle_roll * Counts(state.w_B.x(), wire::kRad_sPerRateCount);
  d.angvel_nick = signs_.angle_nick * Counts(state.w_B.y(), wire::kRad_sPerRateCount);
  d.angvel_yaw = signs_.angle_yaw * Counts(state.w_B.z(), wire::kRad_sPerRateCount);
  d.acc_absolute_value = 10000;
  d.acc_z = d.acc_z_calib = -10000;
  d.height = d.height_reference = Counts(-state.p_NB.z(), wire::kMetresPerCount);
  d.dheight = d.dheight_reference = Counts(-state.v_N.z(), wire::kMetresPerCount);
  return d;
}

wire::GpsDataAdvanced AscTecProcessor::Gps(const VehicleState& state) const {
  const GeodeticPosition place = GeodeticOf(options_.origin, state.p_NB);
  wire::GpsDataAdvanced d;
  d.latitude_best_estimate = d.gps.latitude = Counts(Radians(place.latitude_deg), wire::kRadPerLatitudeCount);
  d.longitude_best_estimate = d.gps.longitude =
      Counts(Radians(place.longitude_deg), wire::kRadPerLatitudeCount);
  d.speed_x_best_estimate = d.gps.speed_x = Counts(state.v_N.y(), wire::kMetresPerCount);
  d.speed_y_best_estimate = d.gps.speed_y = Counts(state.v_N.x(), wire::kMetresPerCount);
  d.gps.height = Counts(place.altitude_m, wire::kMetresPerCount);
  const double course = std::atan2(state.v_N.y(), state.v_N.x());
  d.gps.heading = Counts(course < 0 ? course + 2 * std::numbers::pi : course, wire::kRadPerAngleCount);
  d.gps.horizontal_accuracy = 2000, d.gps.vertical_accuracy = 3000, d.gps.speed_accuracy = 300;
  d.gps.numSV = 10;
  d.gps.status = 0x03;
  return d;
}

wire::RcData AscTecProcessor::Radio() const {
  wire::RcData d;
  d.channels_in.fill(2048);
  d.channels_in[4] = pilot_allows_ ? 4095 : 0;
  d.channels_out = d.channels_in;
  d.lock = 1;
  return d;
}

}  // namespace kestrel
