// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using control::FlightMode;
using control::wire::mavlink::Dialect;

// MAV_RESULT
constexpr std::uint8_t kDone = 0, kNotNow = 1, kRefused = 2, kFailedToDo = 4;

constexpr double kLead_s = 1;  // of setpoints before OFFBOARD
constexpr double kClearOfGround_m = 0.3;
constexpr double kThere_m = 0.5;   // near enough to a place to go on
constexpr double kNearHome_m = 1;  // from so near it does not climb to return
constexpr double kConeSlope = 3;   // of ArduPilot's return (RTL_CONE_SLOPE): near home it climbs less
constexpr int kActReturn = 3, kActLand = 4;  // COM_OBL_RC_ACT

bool OnGround(const control::VehicleState& state) { return state.mode == FlightMode::kStopped; }

// What it is in by itself, and after the pilot's switch was turned off.
const MavlinkMode& Resting(const Dialect& dialect) {
  const bool px4 = &dialect == &control::wire::mavlink::kPx4;
  return *FindMode(dialect, px4 ? MavlinkDoing::kHold : MavlinkDoing::kPilot);
}

}  // namespace

MavlinkFlight::MavlinkFlight(const Dialect& dialect, const MavlinkParameters& parameters)
    : dialect_(dialect), parameters_(parameters), mode_(&Resting(dialect)) {}

bool MavlinkFlight::TakeChanged() { return std::exchange(changed_, false); }
std::vector<MavlinkFlight::Text> MavlinkFlight::TakeTexts() { return std::exchange(texts_, {}); }

std::uint8_t MavlinkFlight::Refuse(std::uint8_t result, const std::string& text) {
  texts_.push_back({true, text});
  return result;
}

void MavlinkFlight::Enter(const MavlinkMode& mode) {
  if (mode_ != &mode) setpoint_.reset(), own_.reset(), returning_.reset();
  mode_ = &mode;
  changed_ = true;
}

std::uint8_t MavlinkFlight::SetMode(MavlinkDoing doing, double now_s, const control::VehicleState& state) {
  const MavlinkMode* mode = FindMode(dialect_, doing);
  return mode ? SetMode(mode->custom_mode, now_s, state) : kRefused;
}

std::uint8_t MavlinkFlight::SetMode(std::uint32_t custom_mode, double now_s,
                                    const control::VehicleState& state) {
  const MavlinkMode* mode = FindMode(dialect_, custom_mode);
  if (mode == nullptr)
    return Refuse(kRefused, "mode refused: " + NameOfMode(dialect_, custom_mode) + " is not emulated");
  if (!pilot_allows_ && mode->doing != MavlinkDoing::kPilot)
    return Refuse(kRefused, "mode refused: the pilot's switch");
  if (mode->doing == MavlinkDoing::kSetpoints && dialect_.setpoints_first) {
    const bool coming = streaming_s_ && now_s - setpoint_s_ <= 1 / dialect_.slowest_setpoints_hz;
    if (!coming || now_s - *streaming_s_ < kLead_s) return Refuse(kNotNow, "offboard refused: no setpoints");
  }
  const bool anew = mode_ != mode;
  Enter(*mode);
  if (mode->doing == MavlinkDoing::kTakeOff && anew && OnGround(state))
    own_ = control::PositionSetpoint{
        {state.p_NB.x(), state.p_NB.y(), home_N_.z() - parameters_.take_off_height_m()}, YawOf(state.R_NB)};
  return kDone;
}

std::uint8_t MavlinkFlight::Arm(bool armed, double now_s, const control::VehicleState& state) {
  if (armed == armed_) return kDone;
  if (!OnGround(state)) return Refuse(kRefused, "refused: in flight");
  armed_ = armed, armed_s_ = now_s, flew_ = false;
  if (armed) home_N_ = state.p_NB;
  Say(armed ? "armed" : "disarmed");
  changed_ = true;
  return kDone;
}

std::uint8_t MavlinkFlight::TakeOff(std::optional<double> height_m, double now_s,
                                    control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  if (!pilot_allows_) return Refuse(kFailedToDo, "take-off refused: the pilot's switch");
  if (!OnGround(state)) return Refuse(kFailedToDo, "take-off refused: in flight");
  if (!px4() && !armed_) return Refuse(kFailedToDo, "take-off refused: not armed");
  if (!px4() && mode_->doing != MavlinkDoing::kSetpoints)
    return Refuse(kFailedToDo, "take-off refused: not in GUIDED");
  double height = height_m.value_or(parameters_.take_off_height_m());
  if (px4() && height < parameters_.take_off_height_m()) {
    height = parameters_.take_off_height_m();
    texts_.push_back({true, fmt::format("using the least take-off height, {:g} m", height)});
  }
  const double z_N = home_N_.z() - height;
  if (!(z_N < state.p_NB.z() - kClearOfGround_m) || !std::isfinite(z_N))
    return Refuse(kFailedToDo, "take-off refused: no height above the ground");
  if (px4()) {
    if (const std::uint8_t result = SetMode(MavlinkDoing::kTakeOff, now_s, state); result != kDone)
      return result;
  }
  setpoint_.reset();
  own_ = control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), z_N}, YawOf(state.R_NB)};
  Say(fmt::format("take-off to {:.1f} m above home", height));
  return kDone;
}

std::uint8_t MavlinkFlight::GoTo(const Eigen::Vector3d& p_N, std::optional<double> yaw, double now_s,
                                 const control::VehicleState& state) {
  if (!armed_ || OnGround(state)) return Refuse(kRefused, "refused: on the ground");
  if (!p_N.allFinite() || p_N.norm() > control::kSanePosition_m) return Refuse(kRefused, "refused: no place");
  if (!px4() && mode_->doing != MavlinkDoing::kSetpoints) return Refuse(kRefused, "refused: not in GUIDED");
  if (px4()) {
    if (const std::uint8_t result = SetMode(MavlinkDoing::kHold, now_s, state); result != kDone)
      return result;
  }
  setpoint_.reset();
  own_ = control::PositionSetpoint{p_N, yaw.value_or(YawOf(state.R_NB))};
  return kDone;
}

bool MavlinkFlight::Take(const MavlinkSetpoint& setpoint, double now_s) {
  if (!streaming_s_ || now_s - setpoint_s_ > 1 / dialect_.slowest_setpoints_hz) streaming_s_ = now_s;
  setpoint_s_ = now_s;
  if (mode_->doing != MavlinkDoing::kSetpoints) return false;
  setpoint_ = setpoint;
  return true;
}

void MavlinkFlight::TakeMalformed(control::Autopilot& aircraft) {
  if (px4() || mode_->doing != MavlinkDoing::kSetpoints) return;
  setpoint_.reset();
  Stop(aircraft);
}

// Standing still, once: then the aircraft holds its place by its own time-out.
void MavlinkFlight::Stop(control::Autopilot& aircraft) {
  own_.reset();
  if (armed_ && !OnGround(aircraft.State())) aircraft.Send(control::VelocitySetpoint{});
}

void MavlinkFlight::NoteGround(double now_s, const control::VehicleState& state) {
  const bool stopped = OnGround(state);
  if (!std::exchange(begun_, true)) armed_ = flew_ = !stopped, armed_s_ = now_s;
  flew_ = flew_ || !stopped;
  if (!armed_ || !stopped || (!flew_ && now_s - armed_s_ <= parameters_.no_take_off_s())) return;
  armed_ = flew_ = false, setpoint_.reset(), own_.reset(), returning_.reset();
  changed_ = true;
  Say("disarmed");
  if (mode_->doing == MavlinkDoing::kLand || mode_->doing == MavlinkDoing::kReturn) Enter(Resting(dialect_));
}

void MavlinkFlight::NotePilot(double now_s, control::Autopilot& aircraft) {
  if (pilot_allows_ == std::exchange(pilot_was_, pilot_allows_)) return;
  changed_ = true;
  if (pilot_allows_) {
    SetMode(MavlinkDoing::kSetpoints, now_s, aircraft.State());
  } else {
    Enter(*FindMode(dialect_, MavlinkDoing::kPilot));
    setpoint_.reset();
    Stop(aircraft);
  }
}

void MavlinkFlight::Follow(double now_s, control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  NoteGround(now_s, state);
  NotePilot(now_s, aircraft);
  if (mode_->doing == MavlinkDoing::kSetpoints) FollowSetpoint(now_s, aircraft);
  if (!armed_) return;
  const bool flying = !OnGround(state);
  switch (mode_->doing) {
    case MavlinkDoing::kLand:
      if (flying) Sink(aircraft);
      break;
    case MavlinkDoing::kReturn:
      if (flying) Return(state, aircraft);
      break;
    case MavlinkDoing::kTakeOff:
      if (own_ && flying && std::abs(state.p_NB.z() - own_->p_N.z()) < kThere_m &&
          state.mode != FlightMode::kTakeOff) {
        const control::PositionSetpoint place = *own_;
        Enter(Resting(dialect_));
        own_ = place;
      }
      break;
    default:
      break;
  }
  if (own_ && !setpoint_) aircraft.Send(*own_);
}

void MavlinkFlight::FollowSetpoint(double now_s, control::Autopilot& aircraft) {
  const control::VehicleState state = aircraft.State();
  const bool late = now_s - setpoint_s_ > parameters_.setpoint_timeout_s();
  if (px4() && late) {
    streaming_s_.reset();
    const int act = parameters_.on_setpoint_loss();
    const auto doing = act == kActReturn ? MavlinkDoing::kReturn
                       : act == kActLand ? MavlinkDoing::kLand
                                         : MavlinkDoing::kHold;
    Enter(*FindMode(dialect_, doing));
    texts_.push_back({true, "no offboard setpoints: " + NameOfMode(dialect_, mode_->custom_mode)});
    return Stop(aircraft);
  }
  if (!setpoint_) return;
  own_.reset();
  if (late && !setpoint_->IsPosition()) {
    setpoint_.reset();
    return Stop(aircraft);
  }
  // ArduPilot leaves the ground by TAKEOFF alone.
  if (armed_ && (px4() || !OnGround(state))) aircraft.Send(setpoint_->At(state));
}

void MavlinkFlight::Sink(control::Autopilot& aircraft) {
  aircraft.Send(control::VelocitySetpoint{{0, 0, parameters_.landing_m_s()}, 0});
}

// Up, over home, down.
void MavlinkFlight::Return(const control::VehicleState& state, control::Autopilot& aircraft) {
  const double distance_m = (state.p_NB - home_N_).head<2>().norm();
  if (!returning_) {
    double height_m = distance_m > kNearHome_m ? parameters_.return_height_m() : 0;
    if (!px4()) height_m = std::min(height_m, kConeSlope * distance_m);
    returning_ = Returning{.from_N = state.p_NB,
                           .z_N = std::min(state.p_NB.z(), home_N_.z() - height_m),
                           .yaw = YawOf(state.R_NB)};
  }
  Returning& r = *returning_;
  r.climbed = r.climbed || std::abs(state.p_NB.z() - r.z_N) < kThere_m;
  r.arrived = r.arrived || (r.climbed && distance_m < kThere_m);
  if (r.arrived) return Sink(aircraft);
  const Eigen::Vector3d& xy_N = r.climbed ? home_N_ : r.from_N;
  aircraft.Send(control::PositionSetpoint{{xy_N.x(), xy_N.y(), r.z_N}, r.yaw});
}

}  // namespace kestrel::sim
