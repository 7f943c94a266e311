// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/flapping.h"

#include <algorithm>
#include <cmath>

namespace kestrel::sim {
namespace {

constexpr double kStop = 0.25;

double LockNumber(const PitchedRotorParameters& rotor, const FlappingParameters& p) {
  return kAirDensity * rotor.lift_slope_per_rad * rotor.chord_m * std::pow(rotor.radius_m, 4) /
         p.blade_inertia_kg_m2;
}

Eigen::Vector2d WithinStops(const Eigen::Vector2d& tilt) { return tilt.cwiseMax(-kStop).cwiseMin(kStop); }

}  // namespace

double FlapTime(const PitchedRotorParameters& rotor, const FlappingParameters& p, double speed_rad_s) {
  return 16 / (LockNumber(rotor, p) * speed_rad_s);
}

double BarTime(const FlappingParameters& p, double speed_rad_s) {
  return 16 / (p.bar_lock_number * speed_rad_s);
}

double CrossCoupling(const PitchedRotorParameters& rotor, const FlappingParameters& p, double speed_rad_s) {
  const double of_a_blade = p.hub_stiffness_n_m / (rotor.blades / 2.0);
  return 8 * of_a_blade / (LockNumber(rotor, p) * p.blade_inertia_kg_m2 * speed_rad_s * speed_rad_s);
}

FlappingState FlappingRate(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                           double nominal_rad_s, const FlappingState& state, const FlappingInput& input) {
  const double w = std::max(input.speed_rad_s, 0.1 * nominal_rad_s), U = w * rotor.radius_m;
  const double t = FlapTime(rotor, p, w), s = static_cast<int>(spin);
  const double blow_back = 2 * p.speed_response * (4.0 / 3 * input.collective - input.through_m_s / U) / U;
  const Eigen::Vector2d rate(input.w_B.y(), input.w_B.x());  // about the axes of longitudinal, lateral tilt
  const auto across = [&](const Eigen::Vector2d& of) { return Eigen::Vector2d(-s * of.y(), s * of.x()); };

  FlappingState d;
  d.disc = (input.cyclic + p.bar_mixing * state.bar - state.disc +
            CrossCoupling(rotor, p, w) * across(state.disc) + across(rate) / w +
            blow_back * Eigen::Vector2d(input.v_B.x(), -input.v_B.y())) /
               t -
           rate;
  d.bar = (p.bar_gain * input.cyclic - state.bar) / BarTime(p, w) - rate;
  return d;
}

FlappingState StepFlapping(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                           double nominal_rad_s, const FlappingState& state, const FlappingInput& input,
                           double dt_s) {
  const auto after = [&](double h, const FlappingState& rate) {
    return FlappingState{WithinStops(state.disc + h * rate.disc), WithinStops(state.bar + h * rate.bar)};
  };
  const FlappingState first = FlappingRate(rotor, p, spin, nominal_rad_s, state, input);
  const FlappingState middle = FlappingRate(rotor, p, spin, nominal_rad_s, after(dt_s / 2, first), input);
  return after(dt_s, middle);
}

}  // namespace kestrel::sim
