// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A rotor whose blades can be pitched together: a helicopter's main rotor or tail rotor. Blade elements with
// uniform inflow, as in V. Gavrilets, B. Mettler, E. Feron, "Dynamic model for a miniature aerobatic
// helicopter", MIT 2001, with the inflow as a state after P. Carpenter, B. Fridovich, NACA TN 3044, 1953.
// It knows neither the vortex ring state nor stall other than by a maximum thrust.
struct PitchedRotorParameters {
  double radius_m = 0.88;
  int blades = 2;
  double chord_m = 0.06;
  double lift_slope_per_rad = 5.5;
  double drag_coefficient = 0.024;        // of the blade section, without lift
  double max_thrust_coefficient = 0.005;  // T / (rho A (wR)^2), either way
};

inline void Fields(FieldVisitor& v, PitchedRotorParameters& p) {
  v({"radius_m", "radius of the rotor"}, p.radius_m, 0.02, 5.0);
  v({"blades", "number of blades"}, p.blades, 2, 8);
  v({"chord_m", "chord of a blade"}, p.chord_m, 0.005, 0.5);
  v({"lift_slope_per_rad", "lift slope of the blade section"}, p.lift_slope_per_rad, 1.0, 7.0);
  v({"drag_coefficient", "drag coefficient of the blade section at zero lift"}, p.drag_coefficient, 0.0, 0.1);
  v({"max_thrust_coefficient", "maximum thrust coefficient T / (rho A (wR)^2), either way: stall"},
    p.max_thrust_coefficient, 1e-4, 0.1);
}

// How the hub moves relative to the air, m/s: in the plane of the rotor, and along its thrust. ground:
// GroundEffect (sim/aircraft/rotor/rotor.h) at the hub's height.
struct RotorFlow {
  double in_plane_m_s = 0, climb_m_s = 0;
  double ground = 1;
};

struct RotorLoads {
  double thrust_n = 0;
  double torque_n_m = 0;  // of the air against the rotation
};

double DiscArea(const PitchedRotorParameters& p);
double Solidity(const PitchedRotorParameters& p);  // blade area over disc area
double MaxThrust(const PitchedRotorParameters& p, double speed_rad_s);

// At a rotor speed, rad/s, a pitch of the blades, rad, and an induced velocity, m/s. With U = wR, v the
// velocity in the plane, c the climb and v_i the velocity through the disc:
//   T = 1/2 rho a s A (U^2 pitch / 3 + v^2 pitch / 2 - U (v_i + c) / 2)
//   Q = T (v_i + c) / w + 1/8 rho A s Cd R (U^2 + 7/3 v^2)
// Near the ground the disc meets less of the induced velocity, by ground^(-3/2): at equal induced power T is
// then ground times what it is away from it, which is what ground says.
RotorLoads LoadsOf(const PitchedRotorParameters& p, double speed_rad_s, double pitch, double induced_m_s,
                   const RotorFlow& flow);
double VelocityThroughDisc(double induced_m_s, const RotorFlow& flow);  // without the climb

// The induced velocity after dt: m dv/dt = T - 2 rho A k v sqrt(v_p^2 + (v + c)^2), with the apparent mass
// m = 0.637 rho 4/3 pi R^3 and k = 0.9 for the losses of the wake (Gavrilets). Linearly implicit: stable for
// any step.
double StepInduced(const PitchedRotorParameters& p, double speed_rad_s, double pitch, double induced_m_s,
                   const RotorFlow& flow, double dt_s);

// In a steady climb away from the ground: the induced velocity that goes with a thrust of 0 or more, and the
// pitch that gives it.
double SteadyInduced(const PitchedRotorParameters& p, double thrust_n, double climb_m_s);
double PitchFor(const PitchedRotorParameters& p, double speed_rad_s, double thrust_n, double climb_m_s);

}  // namespace kestrel::sim
