// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/rotor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kestrel::sim {

// With C = T / (rho A (wR)^2) the thrust coefficient, s the solidity, a the lift slope, l_c = v_c / (wR):
//   blade elements   C = s a / 4 (2/3 theta - l)
//   momentum         l = l_c + C / (2 l)
// Both differentiated by l_c at l_c = 0, where l = l_h = sqrt(C / 2):
//   dC/dl_c = -(s a / 4) dl/dl_c,  dl/dl_c = 1/2 + dC/dl_c / (4 l_h)
// and so dC/dl_c = -2 s a l_h / (16 l_h + s a); dT/dv_c = rho A w R dC/dl_c.
double ClimbCoefficient(const RotorParameters& p) {
  const double area = std::numbers::pi * p.radius_m * p.radius_m;
  const double C = p.thrust_coefficient_n_s2 / (kAirDensity * area * p.radius_m * p.radius_m);
  const double l_h = std::sqrt(C / 2);
  const double sa = p.solidity * p.lift_slope_per_rad;
  return kAirDensity * area * p.radius_m * 2 * sa * l_h / (16 * l_h + sa);
}

double Thrust(const RotorParameters& p, double speed_rad_s, double climb_m_s) {
  const double w = speed_rad_s;
  return std::max(0.0, p.thrust_coefficient_n_s2 * w * w - ClimbCoefficient(p) * w * climb_m_s);
}

Wrench RotorWrench(const RotorParameters& p, double speed_rad_s, Spin spin, const Eigen::Vector3d& v_B,
                   double lift_factor) {
  const double w = speed_rad_s;
  const Eigen::Vector3d v_p(v_B.x(), v_B.y(), 0);
  const double reaction = p.moment_coefficient_m * p.thrust_coefficient_n_s2 * w * w;
  Wrench hub;
  hub.force = -w * p.drag_coefficient_kg * v_p;
  hub.force.z() = -lift_factor * Thrust(p, w, -v_B.z());
  hub.torque = -w * p.rolling_coefficient_kg_m * v_p;
  hub.torque.z() = -static_cast<int>(spin) * reaction;
  return hub;
}

double GroundEffect(double radius_m, double height_m) {
  const double ratio = radius_m / (4 * std::max(height_m, 0.5 * radius_m));
  return 1 / (1 - ratio * ratio);
}

double StepMotor(const RotorParameters& p, double speed_rad_s, double command_rad_s, double dt_s) {
  const double tau = command_rad_s > speed_rad_s ? p.time_constant_up_s : p.time_constant_down_s;
  return command_rad_s + (speed_rad_s - command_rad_s) * std::exp(-dt_s / tau);
}

}  // namespace kestrel::sim
