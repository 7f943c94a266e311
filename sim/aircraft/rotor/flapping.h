// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/yaml/fields.h"
#include "sim/aircraft/rotor/pitched_rotor.h"
#include "sim/aircraft/rotor/rotor.h"

namespace kestrel::sim {

// The blades' flapping, and the stabiliser bar (flybar) that pitches them with its own tilt.
struct FlappingParameters {
  double blade_inertia_kg_m2 = 0.0556;  // of one blade about its root
  double hub_stiffness_n_m = 54;        // moment of the whole hub per rad of the tip path plane
  double speed_response = 0.2;          // K_mu: share of the textbook blow-back that is left
  double bar_lock_number = 0.8;
  double bar_mixing = 0.71;  // cyclic pitch of the blades over tilt of the bar
  double bar_gain = 1.95;    // tilt asked of the bar over cyclic pitch asked of the blades
};

inline void Fields(FieldVisitor& v, FlappingParameters& p) {
  v({"blade_inertia_kg_m2", "moment of inertia of one blade about its root"}, p.blade_inertia_kg_m2, 1e-4,
    5.0);
  v({"hub_stiffness_n_m", "moment of the whole hub per radian of tilt of the tip path plane"},
    p.hub_stiffness_n_m, 0.0, 1e4);
  v({"speed_response", "share of the textbook blow-back by forward speed that is left (K_mu)"},
    p.speed_response, 0.0, 1.0);
  v({"bar_lock_number", "Lock number of the stabiliser bar"}, p.bar_lock_number, 0.05, 10.0);
  v({"bar_mixing", "cyclic pitch of the blades over tilt of the stabiliser bar"}, p.bar_mixing, 0.0, 2.0);
  v({"bar_gain", "tilt asked of the stabiliser bar over cyclic pitch asked of the blades"}, p.bar_gain, 0.0,
    5.0);
}

// Tilts against the shaft, rad: x longitudinal, positive backwards (nose up), y lateral, positive to the
// right; so too cyclic pitch, which is measured by the tilt that it asks for.
struct FlappingState {
  Eigen::Vector2d disc = Eigen::Vector2d::Zero();  // tip path plane: a1, b1
  Eigen::Vector2d bar = Eigen::Vector2d::Zero();
};

// What drives it. v_B, w_B: of the hub relative to the air, and of the body.
struct FlappingInput {
  Eigen::Vector2d cyclic = Eigen::Vector2d::Zero();
  double speed_rad_s = 0, collective = 0, through_m_s = 0;  // rotor speed, pitch, flow through the disc
  Eigen::Vector3d v_B = Eigen::Vector3d::Zero(), w_B = Eigen::Vector3d::Zero();
};

// 16 / (Lock number w), s, with the Lock number rho a c R^4 / I.
double FlapTime(const PitchedRotorParameters& rotor, const FlappingParameters& p, double speed_rad_s);
double BarTime(const FlappingParameters& p, double speed_rad_s);
// Stiffness number 8 (lambda^2 - 1) / Lock number, lambda^2 - 1 = K / (I w^2): the tilt that comes out across
// the one asked for, over the one along it.
double CrossCoupling(const PitchedRotorParameters& rotor, const FlappingParameters& p, double speed_rad_s);

// d/dt of the state. First order in both axes: G. D. Padfield, Helicopter Flight Dynamics, 3.2, without the
// nutation; the bar: B. Mettler, Identification Modeling and Characteristics of Miniature Rotorcraft, 2003,
// ch. 4. With t, t_s the time constants, S the cross coupling, s = 1 for a clockwise rotor and
// -1 for another:
//   a' = (A + K_m d_a - a - s S b + k u) / t - q - s p / (w t)
//   b' = (B + K_m d_b - b + s S a - k v) / t - p + s q / (w t)
//   d' = (K_c (A, B) - d) / t_s - (q, p)
// and the blow-back k = 2 K_mu (4/3 collective - l) / (wR), l the flow through the disc over wR (Gavrilets).
// Below a tenth of nominal_rad_s the blades' droop stops hold them: as at that speed.
FlappingState FlappingRate(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                           double nominal_rad_s, const FlappingState& state, const FlappingInput& input);

// After dt, by the midpoint rule; the tilts stay within the stops of 0.25 rad.
FlappingState StepFlapping(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                           double nominal_rad_s, const FlappingState& state, const FlappingInput& input,
                           double dt_s);

}  // namespace kestrel::sim
