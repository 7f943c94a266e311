// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/pitched_rotor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/aircraft/rotor/rotor.h"

namespace kestrel::sim {
namespace {

constexpr double kWake = 0.9;
constexpr double kApparentMass = 0.637;  // of the air in the sphere round the disc

double Square(double x) { return x * x; }

// How thrust falls with the velocity through the disc, N s/m.
double ThrustSlope(const PitchedRotorParameters& p, double speed_rad_s) {
  return kAirDensity * p.lift_slope_per_rad * Solidity(p) * DiscArea(p) * speed_rad_s * p.radius_m / 4;
}

}  // namespace

double DiscArea(const PitchedRotorParameters& p) { return std::numbers::pi * p.radius_m * p.radius_m; }

double Solidity(const PitchedRotorParameters& p) {
  return p.blades * p.chord_m / (std::numbers::pi * p.radius_m);
}

double MaxThrust(const PitchedRotorParameters& p, double speed_rad_s) {
  return p.max_thrust_coefficient * kAirDensity * DiscArea(p) * Square(speed_rad_s * p.radius_m);
}

double VelocityThroughDisc(double induced_m_s, const RotorFlow& flow) {
  return induced_m_s / (flow.ground * std::sqrt(flow.ground));
}

RotorLoads LoadsOf(const PitchedRotorParameters& p, double speed_rad_s, double pitch, double induced_m_s,
                   const RotorFlow& flow) {
  const double U = speed_rad_s * p.radius_m, area = DiscArea(p), solidity = Solidity(p);
  const double through = VelocityThroughDisc(induced_m_s, flow) + flow.climb_m_s;
  const double v2 = Square(flow.in_plane_m_s);
  const double most = MaxThrust(p, speed_rad_s);
  RotorLoads loads;
  loads.thrust_n = std::clamp(kAirDensity / 2 * p.lift_slope_per_rad * solidity * area *
                                  (pitch * (U * U / 3 + v2 / 2) - U * through / 2),
                              -most, most);
  const double profile =
      kAirDensity / 8 * area * solidity * p.drag_coefficient * p.radius_m * (U * U + 7.0 / 3 * v2);
  loads.torque_n_m = loads.thrust_n * through / std::max(speed_rad_s, 1.0) + profile;
  return loads;
}

double StepInduced(const PitchedRotorParameters& p, double speed_rad_s, double pitch, double induced_m_s,
                   const RotorFlow& flow, double dt_s) {
  const double v = induced_m_s, through = v + flow.climb_m_s;
  const double U = std::hypot(flow.in_plane_m_s, through);
  const double momentum = 2 * kAirDensity * DiscArea(p) * kWake;
  const double mass = kApparentMass * kAirDensity * 4.0 / 3 * DiscArea(p) * p.radius_m;
  const double force = LoadsOf(p, speed_rad_s, pitch, v, flow).thrust_n - momentum * v * U;
  const double stiffness = std::max(0.0, momentum * (U + (U > 0 ? v * through / U : 0.0)));
  return v + dt_s * force / (mass + dt_s * (stiffness + ThrustSlope(p, speed_rad_s)));
}

double SteadyInduced(const PitchedRotorParameters& p, double thrust_n, double climb_m_s) {
  // v (v + c) = T / (2 rho A k), the branch that hovering belongs to
  const double v2 = std::max(0.0, thrust_n) / (2 * kAirDensity * DiscArea(p) * kWake);
  return -climb_m_s / 2 + std::sqrt(Square(climb_m_s / 2) + v2);
}

double PitchFor(const PitchedRotorParameters& p, double speed_rad_s, double thrust_n, double climb_m_s) {
  const double U = speed_rad_s * p.radius_m;
  const double through = SteadyInduced(p, thrust_n, climb_m_s) + climb_m_s;
  return 3 / (U * U) *
         (2 * thrust_n / (kAirDensity * p.lift_slope_per_rad * Solidity(p) * DiscArea(p)) + U * through / 2);
}

}  // namespace kestrel::sim
