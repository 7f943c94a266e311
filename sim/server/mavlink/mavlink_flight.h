// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/autopilot.h"
#include "control/wire/mavlink_dialects.h"
#include "sim/server/mavlink/mavlink_modes.h"
#include "sim/server/mavlink/mavlink_parameters.h"
#include "sim/server/mavlink/mavlink_setpoints.h"

namespace kestrel::sim {

// How an emulated PX4 or ArduPilot flies: its modes, arming, take-off, landing, return, and what it follows when. now_s
// is any clock that runs in real time. Results are MAV_RESULT; what is refused is said in words as well.
//
// Of both: arming and disarming on the ground, disarming after touch-down and where no take-off follows. Of PX4: OFFBOARD
// needs setpoints for a second before, and is left when they stop; a take-off may be commanded before the motors are
// armed. Of ArduPilot: GUIDED is kept, but the aircraft stops when velocities or attitudes stop, or are malformed; on the
// ground setpoints do nothing. Home is where it was armed last, at first the origin of N.
class MavlinkFlight {
 public:
  MavlinkFlight(const control::wire::mavlink::Dialect& dialect, const MavlinkParameters& parameters);

  std::uint8_t SetMode(std::uint32_t custom_mode, double now_s, const control::VehicleState& state);
  std::uint8_t SetMode(MavlinkDoing doing, double now_s, const control::VehicleState& state);
  std::uint8_t Arm(bool armed, double now_s, const control::VehicleState& state);
  // To a height above home, m; none: where the autopilot climbs to by itself.
  std::uint8_t TakeOff(std::optional<double> height_m, double now_s, control::Autopilot& aircraft);
  // To a place, where it holds; yaw: none keeps it.
  std::uint8_t GoTo(const Eigen::Vector3d& p_N, std::optional<double> yaw, double now_s,
                    const control::VehicleState& state);
  void SetHome(const Eigen::Vector3d& p_N) { home_N_ = p_N; }

  // A setpoint that was understood; whether it is followed. Else it came in another mode.
  bool Take(const MavlinkSetpoint& setpoint, double now_s);
  // One that was not.
  void TakeMalformed(control::Autopilot& aircraft);

  void SetPilot(bool allows) { pilot_allows_ = allows; }
  void Follow(double now_s, control::Autopilot& aircraft);

  std::uint32_t mode() const { return mode_->custom_mode; }
  std::uint8_t base_mode() const { return mode_->base_mode; }
  MavlinkDoing doing() const { return mode_->doing; }
  bool armed() const { return armed_; }
  bool pilot_allows() const { return pilot_allows_; }
  const Eigen::Vector3d& home_N() const { return home_N_; }

  // What a heartbeat tells has changed since the last call.
  bool TakeChanged();
  struct Text {
    bool warning = false;
    std::string text;
  };
  std::vector<Text> TakeTexts();

 private:
  struct Returning {
    Eigen::Vector3d from_N;
    double z_N = 0, yaw = 0;
    bool climbed = false, arrived = false;
  };

  bool px4() const { return &dialect_ == &control::wire::mavlink::kPx4; }
  void Enter(const MavlinkMode& mode);
  void Say(const std::string& text) { texts_.push_back({false, text}); }
  std::uint8_t Refuse(std::uint8_t result, const std::string& text);
  void NotePilot(double now_s, control::Autopilot& aircraft);
  void NoteGround(double now_s, const control::VehicleState& state);
  void FollowSetpoint(double now_s, control::Autopilot& aircraft);
  void Return(const control::VehicleState& state, control::Autopilot& aircraft);
  void Sink(control::Autopilot& aircraft);
  void Stop(control::Autopilot& aircraft);

  const control::wire::mavlink::Dialect& dialect_;
  const MavlinkParameters& parameters_;
  const MavlinkMode* mode_;
  bool armed_ = false;
  double armed_s_ = 0;
  bool flew_ = false;  // since it was armed
  bool begun_ = false;
  Eigen::Vector3d home_N_ = Eigen::Vector3d::Zero();

  std::optional<MavlinkSetpoint> setpoint_;
  double setpoint_s_ = 0;                         // when the last came
  std::optional<double> streaming_s_;             // since when they have been coming
  std::optional<control::PositionSetpoint> own_;  // where it goes by itself
  std::optional<Returning> returning_;

  bool pilot_allows_ = true, pilot_was_ = true;
  bool changed_ = false;
  std::vector<Text> texts_;
};

}  // namespace kestrel::sim
