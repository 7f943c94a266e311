// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>

#include "base/yaml/fields.h"
#include "sim/aircraft/actuator_faults.h"
#include "sim/aircraft/free_body.h"
#include "sim/aircraft/rotor/flapping.h"
#include "sim/aircraft/rotor/pitched_rotor.h"
#include "sim/aircraft/rotor/rotor_drive.h"
#include "sim/aircraft/rotor/rotor_shake.h"
#include "sim/sensor/heading_gyro.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// What an autopilot's inner loop of a helicopter is tuned to: see sim/aircraft/helicopter_stabiliser.h.
struct HelicopterGains {
  double attitude_rad_s = 6;  // natural frequency and damping with which errors of roll and pitch die away
  double attitude_damping = 0.9;
  double integral_per_s = 0.5;  // with which what is left of them does
  double disc_rad_s = 25;       // with which the tip path plane is brought to where it should be
  double heading_per_s = 2;
};

// A surface on the tail, across the flow that it meets.
struct FinParameters {
  double area_m2 = 0.012;
  double lift_slope_per_rad = 2;
};

// A rigid airframe under a main rotor with stabiliser bar, and a tail rotor. The defaults are those of the
// Rotomotion SR20 of thesis table B.1; models/vehicles/sr20/sr20.yaml says where they come from.
struct HelicopterParameters {
  double mass_kg = 9.5;
  Eigen::Vector3d inertia_kg_m2{0.268, 0.508, 0.419};
  bool clockwise = true;          // the main rotor, seen from above
  double rotor_height_m = 0.235;  // of the main rotor's hub above the centre of mass
  PitchedRotorParameters rotor;
  FlappingParameters flapping;
  double collective_low_deg = -4, collective_high_deg = 14;
  double cyclic_limit_deg = 8;  // in any direction, of the blades
  double servo_s = 0.02;        // lag of each servo
  PitchedRotorParameters tail_rotor{0.13, 2, 0.029, 5.0, 0.024, 0.05};
  double tail_gear = 6.2;  // tail rotor's speed over main rotor's
  double tail_arm_m = 1.04, tail_height_m = 0.08;
  double tail_low_deg = -20, tail_high_deg = 26;  // pitch; positive pushes against the main rotor's torque
  HeadingGyroParameters heading_gyro;
  DriveParameters drive;
  Eigen::Vector3d drag_area_m2{0.117, 0.257, 0.176};  // Cd A of the fuselage for flow along each axis of B
  FinParameters vertical_fin{0.012, 2}, horizontal_fin{0.01, 3};
  double horizontal_fin_arm_m = 0.81;
  RotorShake shake;
  HelicopterGains gains;
};

inline void Fields(FieldVisitor& v, HelicopterGains& g) {
  v({"attitude_rad_s", "natural frequency with which errors of roll and pitch die away"}, g.attitude_rad_s,
    0.5, 30.0);
  v({"attitude_damping", "damping ratio of that"}, g.attitude_damping, 0.1, 3.0);
  v({"integral_per_s", "rate at which steady errors of roll and pitch are integrated away"}, g.integral_per_s,
    0.0, 5.0);
  v({"disc_rad_s", "bandwidth with which the tip path plane is brought to where it should be"}, g.disc_rad_s,
    1.0, 200.0);
  v({"heading_per_s", "rate at which a heading error dies away"}, g.heading_per_s, 0.1, 20.0);
}

inline void Fields(FieldVisitor& v, FinParameters& p) {
  v({"area_m2", "area of the fin"}, p.area_m2, 0.0, 1.0);
  v({"lift_slope_per_rad", "slope of its lift coefficient over angle of attack"}, p.lift_slope_per_rad, 0.0,
    7.0);
}

inline void Fields(FieldVisitor& v, HelicopterParameters& p) {
  v({"mass_kg", "mass of the aircraft"}, p.mass_kg, 0.05, 200.0);
  v({"inertia_kg_m2", "moments of inertia about the axes of B, through the centre of mass"}, p.inertia_kg_m2,
    1e-5, 100.0);
  v({"clockwise", "whether the main rotor turns clockwise, seen from above"}, p.clockwise);
  v({"rotor_height_m", "height of the main rotor's hub above the centre of mass"}, p.rotor_height_m, 0.0,
    2.0);
  v({"rotor", "main rotor"}, p.rotor);
  v({"flapping", "flapping of the main rotor's blades and the stabiliser bar"}, p.flapping);
  v({"collective_low_deg", "lowest collective pitch"}, p.collective_low_deg, -20.0, 0.0);
  v({"collective_high_deg", "highest collective pitch"}, p.collective_high_deg, 1.0, 25.0);
  v({"cyclic_limit_deg", "maximum cyclic pitch of the blades, in any direction"}, p.cyclic_limit_deg, 0.5,
    20.0);
  v({"servo_s", "time constant of each servo"}, p.servo_s, 1e-4, 1.0);
  v({"tail_rotor", "tail rotor"}, p.tail_rotor);
  v({"tail_gear", "speed of the tail rotor over speed of the main rotor"}, p.tail_gear, 0.5, 20.0);
  v({"tail_arm_m", "distance of the tail rotor behind the centre of mass"}, p.tail_arm_m, 0.1, 10.0);
  v({"tail_height_m", "height of the tail rotor above the centre of mass"}, p.tail_height_m, -1.0, 2.0);
  v({"tail_low_deg", "lowest pitch of the tail rotor; positive pushes against the main rotor's torque"},
    p.tail_low_deg, -45.0, 0.0);
  v({"tail_high_deg", "highest pitch of the tail rotor"}, p.tail_high_deg, 1.0, 45.0);
  v({"heading_gyro", "gyro between pedals and tail rotor"}, p.heading_gyro);
  v({"drive", "motor and governor"}, p.drive);
  v({"drag_area_m2", "drag area (C_D A) of the fuselage for flow along each axis of B"}, p.drag_area_m2, 0.0,
    10.0);
  v({"vertical_fin", "vertical fin, at the tail rotor"}, p.vertical_fin);
  v({"horizontal_fin", "horizontal fin"}, p.horizontal_fin);
  v({"horizontal_fin_arm_m", "distance of the horizontal fin behind the centre of mass"},
    p.horizontal_fin_arm_m, 0.0, 10.0);
  v({"shake", "vibration by the main rotor that the inertial sensors feel"}, p.shake);
  v({"gains", "gains of the autopilot's inner loop"}, p.gains);
}

inline Spin SpinOf(const HelicopterParameters& p) {
  return p.clockwise ? Spin::kClockwise : Spin::kCounterclockwise;
}

// What the autopilot asks of servos, gyro and governor.
struct HelicopterControls {
  double collective = 0;                             // pitch of the main rotor's blades, rad
  Eigen::Vector2d cyclic = Eigen::Vector2d::Zero();  // as in FlappingState, rad
  double yaw_rate = 0;                               // of the pedals, rad/s, clockwise
  double tail_pitch = 0;                             // of the tail rotor, to which the gyro adds, rad
  bool running = false;  // the governor turns the rotor; otherwise the motor is off
};

struct HelicopterState {
  DriveState drive;
  double azimuth = 0;  // of a blade, rad, clockwise from ahead
  double collective = 0, tail_pitch = 0;
  Eigen::Vector2d cyclic = Eigen::Vector2d::Zero();
  double heading_integral = 0;  // of the gyro
  double induced_m_s = 0, tail_induced_m_s = 0;
  FlappingState flapping;
};

// How the hubs move through the air, and each rotor's loads on it. v_B: velocity of the centre of mass
// relative to the air; height_m: of the main hub above the ground, for the ground effect.
struct HelicopterLoads {
  RotorFlow flow, tail_flow;
  RotorLoads rotor, tail;
};
HelicopterLoads LoadsOf(const HelicopterParameters& p, const HelicopterState& state,
                        const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B, double height_m);

// Servos, gyro, governor, inflow and flapping after dt.
HelicopterState StepHelicopter(const HelicopterParameters& p, const HelicopterState& state,
                               const HelicopterControls& controls, const Eigen::Vector3d& v_B,
                               const Eigen::Vector3d& w_B, double height_m, double dt_s,
                               const ActuatorConditions& conditions = {});

// Force and torque about the centre of mass, in B.
//   main rotor: thrust T along (-a, b, -1), its drag rho / 4 A s Cd wR v in the disc's plane, the hub's
//   moment
//     K (b, a), and the reaction of what the motor puts into the main rotor;
//   tail rotor: thrust at the end of the boom; fins: -rho / 2 S (C_L |v_along| + |v|) v (Gavrilets);
//   fuselage: -rho / 2 Cd A |v| v along each axis, in the wake of the main rotor.
Wrench AerodynamicWrench(const HelicopterParameters& p, const HelicopterState& state,
                         const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B, double height_m);

// Hovering level and out of ground effect: the rotors as they then are, but for cyclic, and the controls that
// keep them so.
HelicopterState HoverState(const HelicopterParameters& p);
HelicopterControls HoverControls(const HelicopterState& hover);
double HoverPower_w(const HelicopterParameters& p);  // of the motor

// The aircraft in a MuJoCo model.
class Helicopter {
 public:
  // As FreeBody has it. turning: with the state of hovering, otherwise the rotors stand.
  Helicopter(const HelicopterParameters& parameters, mjModel* model, bool turning,
             const char* body_name = "vehicle");

  void Command(const HelicopterControls& controls) { controls_ = controls; }
  void SetConditions(const ActuatorConditions& conditions) { conditions_ = conditions; }
  // As Multirotor::Apply.
  void Apply(mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m);
  // What the rotor adds to the readings of the step: its shaking, and the tachometer's.
  void Disturb(SensorReadings& readings) const;

  const HelicopterParameters& parameters() const { return parameters_; }
  const HelicopterState& state() const { return state_; }

 private:
  HelicopterParameters parameters_;
  FreeBody body_;
  ActuatorConditions conditions_;
  HelicopterControls controls_;
  HelicopterState state_;
};

}  // namespace kestrel::sim
