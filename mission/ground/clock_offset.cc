// SPDX-License-Identifier: Apache-2.0
#include "mission/ground/clock_offset.h"

#include <algorithm>
#include <cmath>

namespace kestrel::mission {
namespace {

constexpr double kLeastMotion_m2_s2 = 0.02;  // variance of the velocity, of all axes together
constexpr double kLeastWeight = 60;          // measurements
constexpr double kLeastSigma_s = 0.004;      // what is not constant of the difference is no white noise
constexpr double kBeyondDoubt = 4;           // sigmas

}  // namespace

void ClockOffset::Add(double t_s, const Eigen::Vector3d& measured, const Eigen::Vector3d& own,
                      const Eigen::Vector3d& velocity) {
  const double keep = weight_ > 0 ? std::exp(-std::max(0.0, t_s - last_s_) / memory_s_) : 0;
  last_s_ = t_s;
  const Eigen::Vector3d r = measured - own;
  weight_ = keep * weight_ + 1;
  r_ = keep * r_ + r;
  v_ = keep * v_ + velocity;
  rr_ = keep * rr_ + r.squaredNorm();
  vv_ = keep * vv_ + velocity.squaredNorm();
  vr_ = keep * vr_ + velocity.dot(r);
}

std::optional<ClockOffset::Estimate> ClockOffset::Get() const {
  if (weight_ < kLeastWeight) return std::nullopt;
  const double vv = vv_ / weight_ - (v_ / weight_).squaredNorm();
  if (vv < kLeastMotion_m2_s2) return std::nullopt;
  const double vr = vr_ / weight_ - (v_ / weight_).dot(r_ / weight_);
  const double rr = rr_ / weight_ - (r_ / weight_).squaredNorm();
  const double left = std::max(0.0, rr - vr * vr / vv);
  // The residuals of neighbouring frames are alike: a third of them counts.
  return Estimate{-vr / vv, std::max(kLeastSigma_s, std::sqrt(left / vv / (weight_ / 3)))};
}

bool ClockOffset::Apart(double limit_s) const {
  const auto estimate = Get();
  return estimate && std::abs(estimate->offset_s) > limit_s + kBeyondDoubt * estimate->sigma_s;
}

}  // namespace kestrel::mission
