// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string>

#include "sim/aircraft/airframe.h"

namespace kestrel::sim {

// Where an autopilot of four motors has them in its own body frame A, forward, right and down, and how that
// lies in B so that they are the rotors of a Multirotor.
struct Motor {
  double bearing_deg = 0;  // from forward, clockwise seen from above
  Spin spin = Spin::kClockwise;
  int rotor = 0;  // of RotorSpeeds: front, right, back, left
};
struct MotorLayout {
  const char* name;
  std::array<Motor, 4> motors;  // 1 to 4
  double yaw_deg;               // of A in B
};

// The layouts of PX4 and ArduPilot, which agree on both: motor 1 right, 2 left, 3 front, 4 back; and the same
// turned by 45 degrees to the left, 1 front right, 2 back left, 3 front left, 4 back right. An autopilot set
// to quad-x flies the same rotors, its nose between the front and the right one.
//
//   quad-plus  PX4 src/lib/mixer/geometries/quad_plus.toml; ArduPilot libraries/SITL/SIM_Frame.cpp,
//              quad_plus_motors
//   quad-x     PX4 ROMFS/px4fmu_common/init.d-posix/airframes/10016_none_iris (CA_ROTOR*_PX, _PY, and _KM,
//              positive for counterclockwise); ArduPilot the same file, quad_x_motors
//
// PX4's quad_x.toml, of mixers that it no longer has, numbers them otherwise.
std::span<const MotorLayout> MotorLayouts();

// What a motor's command u, 0 to 1 (anything else is brought there; not a number: 0), is of its largest
// thrust: (1 - c) u + c u^2. c = 0: a thrust; c = 1: a rotor speed. Both autopilots make their commands from
// the thrusts that they want by the inverse of this curve: PX4 with c = THR_MDL_FAC, ArduPilot with c =
// MOT_THST_EXPO. With the same c here the thrust is the one they wanted.
double ThrustShare(double command, double curvature);

// The outputs of an autopilot's motors as what a Multirotor's rotors are to do.
class MotorMapping {
 public:
  // Throws std::runtime_error: no layout of that name, or an aircraft that is no Multirotor.
  MotorMapping(const std::string& layout, const AirframeParameters& aircraft);
  Actuation Speeds(const std::array<double, 4>& commands, double curvature) const;  // of motors 1 to 4
  const Eigen::Quaterniond& R_BA() const { return R_BA_; }

 private:
  MotorLayout layout_;
  double max_speed_rad_s_ = 0;
  Eigen::Quaterniond R_BA_;
};

}  // namespace kestrel::sim
