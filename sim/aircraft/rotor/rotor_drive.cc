// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/rotor_drive.h"

#include <algorithm>
#include <cmath>

namespace kestrel::sim {

double DriveTorque(const DriveParameters& p, const DriveState& state) {
  return state.power_w / std::max(state.speed_rad_s, p.speed_rad_s / 4);
}

DriveState StepDrive(const DriveParameters& p, const DriveState& state, bool running, double load_n_m,
                     double dt_s) {
  DriveState next = state;
  double throttle = 0;
  if (running) {
    next.target_rad_s = std::min(p.speed_rad_s, state.target_rad_s + dt_s * p.speed_rad_s / p.spool_s);
    const double error = next.target_rad_s - state.speed_rad_s;
    next.integral = std::clamp(state.integral + dt_s * p.integral * error, 0.0, 1.0);
    throttle = std::clamp(p.gain_s * error + next.integral, 0.0, 1.0);
  } else {
    next.integral = 0;
  }
  next.power_w += (1 - std::exp(-dt_s / p.response_s)) * (throttle * p.power_w - state.power_w);
  next.speed_rad_s =
      std::max(0.0, state.speed_rad_s + dt_s * (DriveTorque(p, next) - load_n_m) / p.inertia_kg_m2);
  if (!running) next.target_rad_s = std::min(p.speed_rad_s, next.speed_rad_s);
  return next;
}

}  // namespace kestrel::sim
