// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "sim/aircraft/airframe.h"

namespace kestrel::sim {

// Where an autopilot has a motor, forward and to the right of the centre, and how it turns.
struct Motor {
  double forward = 0, right = 0;
  Spin spin = Spin::kClockwise;
};

// A layout that autopilots know by a name, its motors in their numbers' order. Those of a frame on rails (H) have
// the outermost at 1 forward and to the right; those of all others are on the circle of 1.
struct MotorLayout {
  std::string name;                     // quad-plus, quad-x, quad-h, and so for hexa and octo
  int frame_class = 0, frame_type = 0;  // ArduPilot's FRAME_CLASS and FRAME_TYPE
  bool rails = false;
  std::vector<Motor> motors;
};

// ArduPilot's tables (libraries/AP_Motors/AP_MotorsMatrix.cpp: setup_quad_matrix, setup_hexa_matrix,
// setup_octa_matrix; plus, X and H). PX4's airframes number plus and X in the same way (ROMFS: 10016_none_iris; the
// generic hexarotor and octorotor), and take any other by CA_ROTOR parameters.
const std::vector<MotorLayout>& MotorLayouts();

// What a motor's command u, 0 to 1 (anything else is brought there; not a number: 0), is of its largest
// thrust: (1 - c) u + c u^2. c = 0: a thrust; c = 1: a rotor speed. Both autopilots make their commands from
// the thrusts that they want by the inverse of this curve: PX4 with c = THR_MDL_FAC, ArduPilot with c =
// MOT_THST_EXPO. With the same c here the thrust is the one they wanted.
double ThrustShare(double command, double curvature);
// The command that gives a share of 0 to 1.
double CommandFor(double thrust_share, double curvature);

// Which rotor of an aircraft each motor of an autopilot turns.
struct MotorOrder {
  const MotorLayout* layout =
      nullptr;                     // null: none that is known, motors are numbered as the rotors are listed
  std::vector<std::size_t> rotor;  // of motor 1 and on
  std::string Name() const;        // of the layout, or "6 rotors as listed"
};

// The layout whose places and spins the rotors have. A rotor may be off its place by a sixth of the way to the next one.
// Throws std::runtime_error: none fits; it says of the nearest what each rotor is and should be.
MotorOrder KnownMotorOrder(const MultirotorParameters& aircraft);
// The same; where none fits, as listed: PX4's parameters tell it where each is.
MotorOrder Px4MotorOrder(const MultirotorParameters& aircraft);

using MotorCommands = std::array<double, kMaxRotors>;  // of motor 1 and on, 0 to 1

// The outputs of an autopilot's motors as what a Multirotor's rotors are to do.
class MotorMapping {
 public:
  MotorMapping(MotorOrder order, const MultirotorParameters& aircraft);
  Actuation Speeds(const MotorCommands& commands, double curvature) const;
  const MotorOrder& order() const { return order_; }

 private:
  MotorOrder order_;
  double max_speed_rad_s_ = 0;
};

// Throws std::runtime_error: no rotors that motors turn, such as a helicopter's.
const MultirotorParameters& MultirotorOf(const AirframeParameters& aircraft);

}  // namespace kestrel::sim
