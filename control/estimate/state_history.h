// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "control/autopilot.h"

namespace kestrel::control {

// The autopilot's recent states, so that a frame meets the attitude of its own exposure and not of its
// arrival.
class StateHistory {
 public:
  explicit StateHistory(double length_s = 2) : length_s_(length_s) {}

  // Times must not go back; a state of the same time replaces the last one.
  void Add(const VehicleState& state);

  // The state at a time, interpolated; at the ends, up to slack_s outside, extrapolated by its velocities.
  // None: further outside, or nothing heard yet.
  std::optional<VehicleState> At(double t_s, double slack_s = 0.15) const;

 private:
  double length_s_;
  std::deque<VehicleState> states_;
};

}  // namespace kestrel::control
