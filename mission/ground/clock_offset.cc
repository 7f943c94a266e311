// SPDX-License-Identifier: Apache-2.0
#include "mission/ground/clock_offset.h"

#include <algorithm>
#include <cmath>

namespace kestrel::mission {
namespace {

constexpr double kSlow_s = 0.7;  // what changes more slowly is left out
constexpr double kLeastMotion_m2_s2 =
    0.002;                               // mean square of what is left of the velocity, of all axes together
constexpr double kLeastWeight = 60;      // measurements
constexpr double kLeastSigma_s = 0.004;  // what is not constant of the difference is no white noise
constexpr double kBeyondDoubt = 4;       // sigmas
constexpr double kLikely = 2;            // the same

}  // namespace

void ClockOffset::Add(double t_s, const Eigen::Vector3d& measured, const Eigen::Vector3d& own,
                      const Eigen::Vector3d& velocity) {
  const double dt = weight_ > 0 ? std::max(0.0, t_s - last_s_) : 0, keep = std::exp(-dt / memory_s_);
  const double share = weight_ > 0 ? 1 - std::exp(-dt / kSlow_s) : 1;
  last_s_ = t_s;
  slow_r_ += share * (measured - own - slow_r_);
  slow_v_ += share * (velocity - slow_v_);
  const Eigen::Vector3d r = measured - own - slow_r_, v = velocity - slow_v_;
  weight_ = keep * weight_ + 1;
  rr_ = keep * rr_ + r.squaredNorm();
  vv_ = keep * vv_ + v.squaredNorm();
  vr_ = keep * vr_ + v.dot(r);
}

std::optional<ClockOffset::Estimate> ClockOffset::Get() const {
  if (weight_ < kLeastWeight) return std::nullopt;
  const double vv = vv_ / weight_;
  if (vv < kLeastMotion_m2_s2) return std::nullopt;
  const double left = std::max(0.0, (rr_ - vr_ * vr_ / vv_) / weight_);
  // The residuals of neighbouring frames are alike: a third of them counts.
  return Estimate{-vr_ / vv_, std::max(kLeastSigma_s, std::sqrt(left / vv / (weight_ / 3)))};
}

bool ClockOffset::Apart(double limit_s) const {
  const auto estimate = Get();
  return estimate && std::abs(estimate->offset_s) > limit_s + kBeyondDoubt * estimate->sigma_s;
}

bool ClockOffset::Together(double limit_s) const {
  const auto estimate = Get();
  return estimate && std::abs(estimate->offset_s) < limit_s - kLikely * estimate->sigma_s;
}

}  // namespace kestrel::mission
