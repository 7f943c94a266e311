// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "control/autopilot.h"
#include "control/wire/mavlink_messages.h"
#include "geometry/pose.h"

// What PX4 and ArduPilot (Copter) want otherwise, and kestrel's setpoints and state as messages. Sources:
// both projects' documentation of off-board and guided flight, and what their receivers do with the fields.
namespace kestrel::control::wire::mavlink {

struct Dialect {
  const char* name;
  std::uint8_t autopilot;       // MAV_AUTOPILOT, in its HEARTBEAT
  std::uint32_t setpoint_mode;  // custom_mode in which it follows setpoints: OFFBOARD, GUIDED
  std::uint32_t land_mode;      // the same
  std::uint32_t return_mode;    // the same
  bool setpoints_first;         // refuses the mode unless setpoints have been coming already
  bool takes_off_by_setpoint;   // a position above it will do; if not, TakeOff must be commanded
  double slowest_setpoints_hz;  // less is taken for a loss
  double setpoint_timeout_s;    // after which it holds its place or does what it is told to do on loss
  double landing_target_timeout_s;
};

// PX4: the time-out is COM_OF_LOSS_T, what follows it COM_OBL_RC_ACT; PLD_BTOUT for the landing target.
inline constexpr Dialect kPx4{.name = "PX4",
                              .autopilot = 12,
                              .setpoint_mode = 6U << 16,
                              .land_mode = 4U << 16 | 6U << 24,
                              .return_mode = 4U << 16 | 5U << 24,
                              .setpoints_first = true,
                              .takes_off_by_setpoint = true,
                              .slowest_setpoints_hz = 2,
                              .setpoint_timeout_s = 1,
                              .landing_target_timeout_s = 5};
// ArduPilot: the time-out is GUID_TIMEOUT, and not for positions. For an AttitudeSetpoint's thrust to be one,
// GUID_OPTIONS must have its bit 3 (8) set: without, it is a rate of climb, 0.5 for none.
inline constexpr Dialect kArduPilot{.name = "ArduPilot",
                                    .autopilot = 3,
                                    .setpoint_mode = 4,
                                    .land_mode = 9,
                                    .return_mode = 6,
                                    .setpoints_first = false,
                                    .takes_off_by_setpoint = false,
                                    .slowest_setpoints_hz = 1,
                                    .setpoint_timeout_s = 3,
                                    .landing_target_timeout_s = 1};

// Of the autopilot that sends this; none: neither, or no autopilot at all.
const Dialect* DialectOf(const Heartbeat& heartbeat);

struct Target {
  std::uint8_t system = 1, component = 1;  // of the autopilot
};

// The companion's own.
Heartbeat CompanionHeartbeat();

// A velocity goes out in the heading frame with its yaw rate, a position in N with its yaw: its local frame
// is N. (Older PX4s turn the velocity by roll and pitch too.) An attitude has a yaw on the wire, which
// the caller turns on by the yaw rate, beginning with the state's own.
Message ToMessage(const Setpoint& setpoint, double yaw, const Dialect& dialect, Target target,
                  std::uint32_t time_boot_ms);
FlightMode ModeFor(const Setpoint& setpoint);

CommandLong Arm(bool armed, Target target);
CommandLong SetCustomMode(std::uint32_t custom_mode, const Dialect& dialect, Target target);
// On the spot, to a height above where it stands; altitude_m: of that place above the sea, which PX4 wants.
CommandLong TakeOff(double height_m, double altitude_m, const Dialect& dialect, Target target);
// That it sends a message at a rate.
CommandLong SetMessageInterval(std::uint32_t id, double rate_hz, Target target);

// PX4 wants the target's place in N, ArduPilot in B with the distance.
LandingTarget ToLandingTarget(const Eigen::Vector3d& p_NT, const Pose& X_NB, const Dialect& dialect,
                              std::uint64_t time_usec);

// The autopilot's state from what it tells of it. Only its own messages may be taken: by Frame::system and
// component.
class Telemetry {
 public:
  // False: it has nothing to do with the state, or holds a number that is none.
  bool Handle(const Message& message);

  // The setpoints of what mode are being sent: on the wire all are one mode.
  void Sent(const Setpoint& setpoint) { sent_ = ModeFor(setpoint); }

  // At the time of the newest attitude or position; the older of the two is turned or moved on to it. None:
  // heartbeat, attitude or position never came, or one of the latter two is 0.5 s older than the other.
  // Armed and in another mode than the one for setpoints is kHold, whoever flies it then. An autopilot does
  // not tell when it holds its place in that mode because setpoints went stale, nor what saturates.
  std::optional<VehicleState> State(const Dialect& dialect) const;

 private:
  struct Turning {
    double t_s = 0;
    Eigen::Quaterniond R_NB = Eigen::Quaterniond::Identity();
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();
  };
  struct Moving {
    double t_s = 0;
    Eigen::Vector3d p_NB = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();
  };
  bool Note(const Turning& turning);

  std::optional<Heartbeat> heartbeat_;
  std::optional<Turning> turning_;
  std::optional<Moving> moving_;
  std::optional<std::uint8_t> landed_state_;
  FlightMode sent_ = FlightMode::kVelocity;
};

}  // namespace kestrel::control::wire::mavlink
