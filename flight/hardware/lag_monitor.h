// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "control/autopilot.h"
#include "control/estimate/velocity_lag.h"

namespace kestrel::flight {

// Whether an autopilot in flight follows velocities later than the flight's gains allow.
class LagMonitor {
 public:
  static constexpr double kPeriod_s = 1;  // between two judgements
  static constexpr int kInARow = 2;       // that must agree

  explicit LagMonitor(const control::VelocityLag& most) : max_(most) {}

  // In the order of time, of each frame: what was sent, and the state it was sent on. Returns what is to be
  // told, once of each direction; empty: nothing.
  std::string Note(double now_s, const std::optional<control::Setpoint>& sent,
                   const control::VehicleState& state);
  const std::string& told() const { return told_; }  // all of it, in words; empty: nothing

 private:
  struct Direction {
    int late = 0;  // judgements in a row
    bool told = false;
  };
  std::string Judge(const char* name, const std::optional<control::VelocityLagEstimator::Late>& late,
                    double max_s, Direction& direction);

  control::VelocityLag max_;
  control::VelocityLagEstimator estimator_;
  std::optional<double> judged_s_;
  Direction horizontal_, vertical_;
  std::string told_;
};

}  // namespace kestrel::flight
