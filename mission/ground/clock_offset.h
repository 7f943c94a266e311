// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel::mission {

// How far a camera's clock is ahead of the autopilot's, from what it measures of a moving aircraft: a place that
// was measured offset_s before the time it is stamped with is off by velocity times offset. The rest of the
// difference to the autopilot's own position wanders, as satellite navigation does, by decimetres in ten seconds.
// So only what changes within a second is looked at, of the difference and of the velocity alike: least squares with
// forgetting, of which only a velocity that changes tells anything.
class ClockOffset {
 public:
  explicit ClockOffset(double memory_s = 40) : memory_s_(memory_s) {}

  // A place measured and what the autopilot's own motion has for that stamp, in the same frame.
  void Add(double t_s, const Eigen::Vector3d& measured, const Eigen::Vector3d& own,
           const Eigen::Vector3d& velocity);

  struct Estimate {
    double offset_s = 0, sigma_s = 0;
  };
  std::optional<Estimate> Get() const;  // none: too little motion yet

  // Whether the clock is apart by more than this, beyond doubt.
  bool Apart(double limit_s) const;
  // Whether it is likely to be apart by less.
  bool Together(double limit_s) const;

 private:
  double memory_s_, last_s_ = 0;
  double weight_ = 0;
  Eigen::Vector3d slow_r_ = Eigen::Vector3d::Zero(), slow_v_ = Eigen::Vector3d::Zero();
  double rr_ = 0, vv_ = 0, vr_ = 0;
};

}  // namespace kestrel::mission
