// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "control/autopilot.h"
#include "control/estimate/velocity_lag.h"

namespace kestrel {

// Whether an autopilot in flight follows velocities later than the flight's gains allow.
class LagWatch {
 public:
  static constexpr double kPeriod_s = 2;  // between two judgements
  static constexpr int kInARow = 2;       // that must agree

  explicit LagWatch(const VelocityLag& most) : most_(most) {}

  // In the order of time, of each frame: what was sent, and the state it was sent on. Returns what is to be
  // told, once of each direction; empty: nothing.
  std::string Note(double now_s, const std::optional<Setpoint>& sent, const VehicleState& state);
  const std::string& told() const { return told_; }  // all of it, in words; empty: nothing

 private:
  struct Direction {
    int late = 0;  // judgements in a row
    bool told = false;
  };
  std::string Judge(const char* name, const std::optional<VelocityLagEstimator::Late>& late, double most_s,
                    Direction& direction);

  VelocityLag most_;
  VelocityLagEstimator estimator_;
  std::optional<double> judged_s_;
  Direction horizontal_, vertical_;
  std::string told_;
};

}  // namespace kestrel
