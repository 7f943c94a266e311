// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kestrel {

// Keeps a simulation to a wall clock. What it is late by up to kCatchUp_s is caught up; what is beyond is
// given up for good: the simulation's time is stretched, and nothing is skipped. All times in s.
class RealTime {
 public:
  static constexpr double kCatchUp_s = 0.05;

  // The wall clock's time when the simulation is at 0.
  explicit RealTime(double wall_s) : zero_s_(wall_s), told_wall_s_(wall_s) {}

  // Where the simulation, which is at t_s, should be now.
  double Due(double wall_s, double t_s);
  // When the simulation will be due to be at t_s.
  double WallOf(double t_s) const { return zero_s_ + t_s; }

  double stretched_s() const { return stretched_s_; }  // given up until now
  // The same since this was last asked, no more than once a second; none: nothing, or too early.
  std::optional<double> News(double wall_s);

 private:
  double zero_s_, stretched_s_ = 0, told_s_ = 0, told_wall_s_;
};

}  // namespace kestrel
