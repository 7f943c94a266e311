// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/yaml/fields.h"
#include "sim/aircraft/rotor/wrench.h"

namespace kestrel::sim {

constexpr double kAirDensity = 1.225;  // kg/m3, standard atmosphere at sea level

// A rotor of fixed pitch with its motor. The defaults are those of the AscTec Pelican.
struct RotorParameters {
  double thrust_coefficient_n_s2 = 9.9865e-6;  // k_f: thrust in still air is k_f w^2
  double moment_coefficient_m = 0.016;         // k_m: reaction torque over thrust in still air
  double drag_coefficient_kg = 8.06428e-5;     // lambda_1: in-plane force per rotor speed and air speed
  double rolling_coefficient_kg_m = 1e-6;      // mu_1: rolling moment per rotor speed and air speed
  double radius_m = 0.128;
  double solidity = 0.1;            // blade area over disc area
  double lift_slope_per_rad = 5.7;  // of the blade section
  double time_constant_up_s = 0.0125;
  double time_constant_down_s = 0.025;
  double max_speed_rad_s = 838;
};

inline void Fields(FieldVisitor& v, RotorParameters& p) {
  v({"thrust_coefficient_n_s2", "k_f: thrust in still air is k_f w^2"}, p.thrust_coefficient_n_s2, 1e-8,
    1e-2);
  v({"moment_coefficient_m", "k_m: reaction torque over thrust in still air"}, p.moment_coefficient_m, 1e-4,
    1.0);
  v({"drag_coefficient_kg", "lambda_1: in-plane force per rotor speed and air speed"}, p.drag_coefficient_kg,
    0.0, 1e-2);
  v({"rolling_coefficient_kg_m", "mu_1: rolling moment per rotor speed and air speed"},
    p.rolling_coefficient_kg_m, 0.0, 1e-2);
  v({"radius_m", "radius of the rotor"}, p.radius_m, 0.01, 2.0);
  v({"solidity", "blade area over disc area"}, p.solidity, 0.01, 0.5);
  v({"lift_slope_per_rad", "lift slope of the blade section"}, p.lift_slope_per_rad, 1.0, 7.0);
  v({"time_constant_up_s", "time constant of the motor when speeding up"}, p.time_constant_up_s, 1e-4, 1.0);
  v({"time_constant_down_s", "time constant of the motor when slowing down"}, p.time_constant_down_s, 1e-4,
    1.0);
  v({"max_speed_rad_s", "maximum rotor speed"}, p.max_speed_rad_s, 10.0, 10000.0);
}

// Which way a rotor turns, seen from above.
enum class Spin { kClockwise = 1, kCounterclockwise = -1 };

// Thrust lost per rotor speed and speed of climb, N s2/m: dT = -k_c w v_c. From momentum theory and blade
// elements about hover, with uniform inflow: G. D. Padfield, Helicopter Flight Dynamics, 2.2 (heave damping).
// For fixed pitch the thrust coefficient, and with it the inflow ratio of hover, is the same at all rotor
// speeds, so k_c is a constant.
double ClimbCoefficient(const RotorParameters& p);

// Thrust along the shaft, N, at a rotor speed of 0 rad/s or more: k_f w^2 - k_c w v_c, never negative.
// climb_m_s: velocity of the hub relative to the air, along the thrust. Linear about hover: good while it is
// below about half the induced velocity of hover; it does not know the vortex ring state.
double Thrust(const RotorParameters& p, double speed_rad_s, double climb_m_s);

// Force and torque of a rotor about its hub, in B, its thrust along -z of B. v_B: velocity of the hub
// relative to the air, m/s; v_p its part in the plane of the rotor. lift_factor multiplies the thrust (ground
// effect). Force: thrust, and -w lambda_1 v_p. Torque: the reaction -+ k_m k_f w^2 against the spin, and -w
// mu_1 v_p. After P. Martin, E. Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA
// 2010, in the form of RotorS (gazebo_motor_model.cpp), which the coefficients come from.
Wrench RotorWrench(const RotorParameters& p, double speed_rad_s, Spin spin, const Eigen::Vector3d& v_B,
                   double lift_factor = 1);

// Thrust in ground effect over thrust out of it, at equal power: 1 / (1 - (R / 4z)^2), z the height of the
// rotor above the ground. I. C. Cheeseman, W. E. Bennett, ARC R&M 3021, 1955, in hover. Below z = R/2, where
// it nears its singularity, it stays at 4/3.
double GroundEffect(double radius_m, double height_m);

// Rotor speed after dt, rad/s: a first-order lag, with its own time constants for speeding up and slowing
// down. Exact for a command that is constant over the step.
double StepMotor(const RotorParameters& p, double speed_rad_s, double command_rad_s, double dt_s);

}  // namespace kestrel::sim
