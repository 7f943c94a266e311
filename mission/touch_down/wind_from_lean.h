// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "control/autopilot.h"

namespace kestrel::mission {

// The velocity of the air past an aircraft from its lean. A rotorcraft in steady flight leans so far that its thrust
// balances its drag, which grows about in proportion to the air's speed: g tan(lean) = drag v. Smoothed, because in
// the short term it leans in order to accelerate.
class WindFromLean {
 public:
  // drag_per_s: deceleration, m/s^2, by each m/s of air.
  explicit WindFromLean(double drag_per_s) : drag_per_s_(drag_per_s) {}

  void Add(const control::VehicleState& state);
  // m/s, level, of the air over the aircraft. Zero until the first state.
  const Eigen::Vector2d& air_N() const { return air_N_; }
  double speed_m_s() const { return air_N_.norm(); }

 private:
  double drag_per_s_;
  double t_s_ = 0;
  bool begun_ = false;
  Eigen::Vector2d air_N_ = Eigen::Vector2d::Zero();
};

}  // namespace kestrel::mission
