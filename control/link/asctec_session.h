// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "base/yaml/fields.h"
#include "control/law/velocity_loop.h"
#include "control/link/autopilot_link.h"
#include "control/link/local_geodesy.h"
#include "control/wire/asctec.h"
#include "control/wire/asctec_signs.h"

namespace kestrel::control {

struct AscTecOptions {
  std::string device = "/dev/ttyUSB0";
  // "attitude": setpoints become attitudes and thrust by the VelocityLoop here, which the port is known to
  // heed. "gps": velocities go to the processor's own GPS mode. Unverified: that mode is documented of
  // another port of the processor; one that does not heed it on this port would take the velocity for an
  // attitude.
  std::string mode = "attitude";
  std::string signs = "asctec";  // control/wire/asctec_signs.h
  double cycle_s = 0.04;         // the line has no room for less than 0.035
  double battery_v = 10.4;
  int switch_channel = 5;
  double full_climb_m_s = 2;  // not documented
  // Starts the motors on a position above the aircraft, by thrust 0 and full yaw, and stops them after a
  // touch-down (attitude mode). Otherwise both are the pilot's.
  bool motors = true;
  VelocityLoopOptions velocity_loop;
};

inline void Fields(FieldVisitor& v, AscTecOptions& o) {
  v({"device", "serial device of the AscTec processor; kestrel fly takes that of --autopilot instead"},
    o.device);
  v({"mode", "what is sent: attitude and thrust, or velocities to the processor's own GPS mode"}, o.mode,
    {"attitude", "gps"});
  v({"signs",
     "which way angles and sticks count: as AscTec's firmware has it, or as the ROS driver asctec_drivers"},
    o.signs, {"asctec", "ros"});
  v({"cycle_s", "period of a cycle of requests, each of which gives a state and takes a command"}, o.cycle_s,
    0.035, 0.5);
  v({"battery_v", "battery voltage below which the battery is reported as low"}, o.battery_v, 0.0, 60.0);
  v({"switch_channel", "channel of a pilot's switch that must be above its middle; 0: none"},
    o.switch_channel, 0, 8);
  v({"full_climb_m_s", "climb rate at full deflection of the thrust stick in GPS mode"}, o.full_climb_m_s,
    0.1, 20.0);
  v({"motors", "start the motors for a take-off and stop them after a touch-down; false: the pilot does"},
    o.motors);
  v({"velocity_loop", "controller from velocity and position to attitude and thrust"}, o.velocity_loop);
}

// The PC's end of the AscTec low-level processor's line, without line, thread and clock: bytes in, bytes out,
// at times on any one clock that runs evenly.
//
// Each cycle asks for IMU_CALCDATA and GPS_DATA_ADVANCED, and in turn for LL_STATUS and RC_DATA: at most 224
// of the 230 bytes that the line carries in 0.04 s. A cycle ends when all has come, or is given up; it makes
// a VehicleState of the time at which IMU_CALCDATA began to leave, so far as the line tells, and a CTRL_INPUT
// if there is a setpoint; a new setpoint has one of its own at once. Place and speed are GPS_DATA_ADVANCED's
// best estimate, from the first fix on; height and climb are IMU_CALCDATA's, from the first one on. Without a
// fix there is no state.
//
// Setpoints are sent while the pilot allows it (bit 0x20 of flightMode, no emergency, and his switch), while
// the state is young, and for kRepeat_s after Send. A CTRL_INPUT is repeated by that
// of the next cycle, acknowledged or not; when five in a row are not within 0.1 s, that is an error.
class AscTecSession {
 public:
  explicit AscTecSession(const AscTecOptions& options);

  void Opened(double now_s);  // the line is there, at first or again
  void Closed(const std::string& why);
  void Receive(double now_s, std::span<const std::uint8_t> bytes);
  wire::Bytes Say(double now_s);  // what is due; to be called every few milliseconds

  void Send(double now_s, const Setpoint& setpoint);
  void Aid();  // which the processor does not take: an error from then on
  void Silence();
  const VehicleState& State() const { return state_; }
  LinkHealth Health(double now_s) const;

  std::uint64_t unacknowledged() const { return unacknowledged_; }  // CTRL_INPUTs in all
  std::uint64_t cycles_lost() const { return cycles_lost_; }        // of which something did not come

 private:
  template <class Message>
  struct Heard {
    Message message;
    double t_s = 0;  // when it began to leave
  };
  enum class Motors { kIdle, kStarting, kTakingOff, kFlying, kStopping, kRefused };

  void Handle(double now_s, const wire::Telemetry& message);
  void EndCycle(double now_s);
  void MakeState(double now_s);
  bool InFlight() const;
  std::optional<bool> PilotAllows(double now_s) const;
  std::optional<wire::CtrlInput> Command(double now_s);
  wire::CtrlInput Follow(double now_s, const Setpoint& setpoint);
  wire::CtrlInput FollowByAttitude(double now_s, const VelocitySetpoint& wanted);
  VelocityLoopOutput Loop(double now_s, const VelocitySetpoint& wanted) const;
  wire::CtrlInput ByGpsMode(const VelocitySetpoint& wanted) const;
  wire::CtrlInput Counts(const AttitudeSetpoint& wanted) const;
  void Rest();

  AscTecOptions options_;
  wire::AscTecSigns signs_;

  bool open_ = false;
  std::string closed_why_ = "not opened yet";
  double opened_s_ = 0;
  wire::TelemetryParser parser_;
  wire::LinkCounts earlier_;  // of the line before it was opened again
  std::optional<double> heard_s_;
  bool unread_ = false;  // since then the line has not been told to be idle

  std::uint16_t awaited_ = 0;  // request bits of frames that are still to come
  bool cycling_ = false;
  double asked_s_ = 0, next_cycle_s_ = 0, cycle_limit_s_ = 0;
  std::uint64_t cycle_ = 0, cycles_lost_ = 0;

  std::optional<Heard<wire::ImuCalcData>> imu_;
  bool imu_is_new_ = false;
  std::optional<Heard<wire::GpsDataAdvanced>> gps_;
  std::optional<Heard<wire::LlStatus>> status_;
  std::optional<Heard<wire::RcData>> rc_;
  std::optional<LocalPlane> plane_;
  std::optional<std::int32_t> ground_;  // height of the first IMU_CALCDATA
  VehicleState state_;
  std::optional<double> state_s_;  // when it was complete

  std::optional<Setpoint> setpoint_;
  double setpoint_s_ = 0;
  bool setpoint_is_new_ = false;
  double commanded_s_ = 0;
  std::uint64_t sent_ = 0, unacknowledged_ = 0;
  std::deque<double> unanswered_;  // when they were sent
  int missed_ = 0;                 // acknowledgements in a row
  std::string refused_;
  bool aid_asked_ = false;

  VelocityLoopState loop_;
  TouchDown touch_;
  Motors motors_ = Motors::kIdle;
  double motors_since_s_ = 0, take_off_z_ = 0;
};

}  // namespace kestrel::control
