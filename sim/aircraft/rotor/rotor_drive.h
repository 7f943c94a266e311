// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/fields.h"

namespace kestrel::sim {

// Motor and governor, which holds the main rotor's speed: throttle = K_p e + K_i integral of e, between 0 and
// 1 of the maximum power (Gavrilets, Mettler, Feron 2001, as in sim/aircraft/rotor/pitched_rotor.h), and a
// lag of the motor.
struct DriveParameters {
  double speed_rad_s = 125;  // of the main rotor, governed
  double power_w = 1400;     // the largest
  double response_s = 0.05;  // lag of the motor's power
  double gain_s = 0.05;
  double integral = 0.1;
  double spool_s = 4;            // from rest to the governed speed
  double inertia_kg_m2 = 0.139;  // of all that turns, as felt at the main rotor's shaft
};

inline void Fields(FieldVisitor& v, DriveParameters& p) {
  v({"speed_rad_s", "governed speed of the main rotor"}, p.speed_rad_s, 10.0, 1000.0);
  v({"power_w", "maximum power of the motor"}, p.power_w, 10.0, 1e5);
  v({"response_s", "time constant of the motor's power"}, p.response_s, 0.001, 5.0);
  v({"gain_s", "proportional gain of the governor: throttle per speed error"}, p.gain_s, 0.0, 10.0);
  v({"integral", "integral gain of the governor"}, p.integral, 0.0, 10.0);
  v({"spool_s", "time from rest to the governed speed"}, p.spool_s, 0.1, 60.0);
  v({"inertia_kg_m2", "moment of inertia of all that turns, as felt at the main rotor's shaft"},
    p.inertia_kg_m2, 1e-3, 100.0);
}

struct DriveState {
  double speed_rad_s = 0;   // of the main rotor
  double target_rad_s = 0;  // what the governor holds now: it rises from rest
  double integral = 0;      // of throttle
  double power_w = 0;       // of the motor
};

// Torque of the motor on the main rotor's shaft, N m. At low speed it is no more than at a quarter of the
// governed one.
double DriveTorque(const DriveParameters& p, const DriveState& state);

// After dt against a load, N m at the main rotor's shaft. Not running: the motor is off, and the rotor runs
// down freely.
DriveState StepDrive(const DriveParameters& p, const DriveState& state, bool running, double load_n_m,
                     double dt_s);

}  // namespace kestrel::sim
