// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <array>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/aircraft/actuator_faults.h"
#include "sim/aircraft/free_body.h"
#include "sim/aircraft/rotor/rotor.h"
#include "sim/aircraft/rotor_layout.h"

namespace kestrel::sim {

// A rigid airframe with rotors of one kind, their shafts along -z of B. Where no rotors are listed it has four in a
// plus: front, right, back, left, along +x, +y, -x, -y of B. Front and back turn clockwise, right and left
// counterclockwise. The defaults are those of the AscTec Pelican.
struct MultirotorParameters {
  double mass_kg = 1.3;
  Eigen::Vector3d inertia_kg_m2{0.0125, 0.0125, 0.025};  // about the axes of B, through the centre of mass
  std::vector<RotorPlace> rotors;                        // none: four in a plus
  double arm_m = 0.21;                                   // from the centre to each shaft of the plus
  double rotor_height_m = 0.05;                          // of the rotors above the centre of mass
  Eigen::Vector3d drag_area_m2{0.01, 0.01, 0.02};        // Cd A of the body for flow along each axis of B
  RotorParameters rotor;
};

inline void Fields(FieldVisitor& v, MultirotorParameters& p) {
  v({"mass_kg", "mass of the aircraft"}, p.mass_kg, 0.05, 50.0);
  v({"inertia_kg_m2", "moments of inertia about the axes of B, through the centre of mass"}, p.inertia_kg_m2,
    1e-5, 10.0);
  v({"rotors",
     "where each rotor is and how it turns, 4 to 12 of them; none: four in a plus, arm_m from the centre"},
    p.rotors);
  if (p.rotors.empty())
    v({"arm_m", "distance of each rotor's shaft from the centre of mass"}, p.arm_m, 0.03, 2.0);
  v({"rotor_height_m", "height of the rotors above the centre of mass"}, p.rotor_height_m, -0.5, 0.5);
  v({"drag_area_m2", "drag area (C_D A) of the body for flow along each axis of B"}, p.drag_area_m2, 0.0,
    1.0);
  v({"rotor", "each of the rotors, which are of one kind"}, p.rotor);
}

// No more than kMaxRotors of those listed.
RotorLayout LayoutOf(const MultirotorParameters& p);
RotorLimits LimitsOf(const RotorParameters& rotor);

// Rotor speeds that give a thrust, N along -z of B, and a torque, N m in B, in still air. Where the rotors
// cannot give both, roll and pitch torque come first (scaled down together), then thrust, then yaw torque.
RotorSpeeds Allocate(const MultirotorParameters& p, double thrust, const Eigen::Vector3d& torque_B);

// Force and torque of rotors and body about the centre of mass, in B. v_B: velocity of the centre of mass
// relative to the air; w_B: rad/s; heights_m: of each rotor above the ground, for the ground effect. Drag of
// the body: along each axis -rho / 2 Cd A |v| v.
Wrench AerodynamicWrench(const MultirotorParameters& p, const RotorSpeeds& speeds, const Eigen::Vector3d& v_B,
                         const Eigen::Vector3d& w_B, const std::array<double, kMaxRotors>& heights_m);

// The aircraft in a MuJoCo model: a body with a free joint.
class Multirotor {
 public:
  // As FreeBody has it.
  Multirotor(const MultirotorParameters& parameters, mjModel* model, const char* body_name = "vehicle");

  // Speeds asked of the motors, rad/s; brought into [0, max].
  void Command(const RotorSpeeds& speeds);
  void SetConditions(const ActuatorConditions& conditions) { conditions_ = conditions; }

  // Advances the motors by dt and puts the aerodynamic force and torque on the body, in place of what
  // xfrc_applied held for it. To be called before mj_step, with the state it starts from. wind_N: velocity of
  // the air, m/s. surface_m: height of the ground above the origin of N.
  void Apply(mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m);

  const MultirotorParameters& parameters() const { return parameters_; }
  const RotorSpeeds& speeds() const { return speeds_; }
  // A motor is asked for its maximum speed, or one stands still while others turn.
  bool saturated() const;
  // Rotor speed that carries the weight in still air, rad/s.
  double HoverSpeed() const;
  RotorSpeeds Allocate(double thrust, const Eigen::Vector3d& torque_B) const {
    return kestrel::sim::Allocate(parameters_, thrust, torque_B);
  }

 private:
  MultirotorParameters parameters_;
  RotorLayout layout_;
  FreeBody body_;
  double gravity_m_s2_;
  ActuatorConditions conditions_;
  RotorSpeeds command_{}, speeds_{};
};

}  // namespace kestrel::sim
