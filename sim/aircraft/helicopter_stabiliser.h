// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/aircraft/attitude_demand.h"
#include "sim/aircraft/helicopter.h"

namespace kestrel::sim {

// The inner loop of a helicopter: collective, cyclic and pedals for the attitude wanted.
//
// Roll and pitch: an angular acceleration, fed forward and with feedback on attitude, rate and the integral
// of attitude, is a moment, and a moment is a tilt of the tip path plane, (K + T h) per rad. A model of disc
// and bar, run on the cyclic that was sent, through the servos, and the rates that were felt, says how they
// lie now; the cyclic that brings the disc to its place at disc_rad_s is FlappingRate's equation solved for
// it, the bar and the rates made up for. Collective: what blade elements and momentum give for the thrust
// wanted, at the speed of the climb and of the rotor. Pedals: a rate for the heading gyro; and mixed into the
// tail rotor what holds the torque that this thrust costs, so that a lift-off or a climb does not have to
// turn the aircraft before the gyro learns of it.
class HelicopterStabiliser {
 public:
  explicit HelicopterStabiliser(const HelicopterParameters& aircraft) : aircraft_(aircraft) {}

  HelicopterControls Step(double dt_s, const AttitudeDemand& demand, const SensedMotion& sensed);
  bool limited() const { return limited_; }  // collective or cyclic is at its limit
  void Stop();
  bool Ready(const SensedMotion& sensed) const;  // the rotor has its speed, so that it can lift

 private:
  HelicopterParameters aircraft_;
  Eigen::Vector2d integral_ = Eigen::Vector2d::Zero();  // of pitch, roll, rad s
  Eigen::Vector2d cyclic_ = Eigen::Vector2d::Zero();    // as the servos have it
  FlappingState flapping_;
  bool limited_ = false;
};

}  // namespace kestrel::sim
