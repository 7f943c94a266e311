// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/plane_depth.h"

#include <algorithm>
#include <cmath>

namespace kestrel::control {
namespace {

constexpr double kImageGap_s = 1;    // after which images are not compared, nor velocities integrated
constexpr double kLongestWay_s = 2;  // of a way, whose error grows with time
constexpr double kMinDepth_m = 0.1, kMaxDepth_m = 100;

}  // namespace

PlaneDepth::PlaneDepth(const PlaneDepthOptions& options)
    : options_(options),
      inverse_(1 / options.depth_m),
      variance_(std::pow(options.share / options.depth_m, 2)) {}

void PlaneDepth::Add(double t_s, std::span<const Eigen::Vector2d> s, const Eigen::Vector3d& v) {
  const double dt = t_s - t_s_;
  t_s_ = t_s;
  const auto begin = [&] {
    then_.assign(s.begin(), s.end());
    then_s_ = t_s;
    way_.setZero();
  };
  if (then_.size() != s.size() || !(dt >= 0 && dt < kImageGap_s)) return begin();
  way_ += dt * v;
  // The depth falls as the camera sinks: d(1/Z)/dt = v_z / Z^2.
  const double growth = 1 + 2 * inverse_ * v.z() * dt;
  inverse_ = std::clamp(inverse_ + inverse_ * inverse_ * v.z() * dt, 1 / kMaxDepth_m, 1 / kMinDepth_m);
  variance_ = growth * growth * variance_ + std::pow(options_.change_per_s * inverse_, 2) * dt;
  const double age_s = t_s - then_s_;
  if (way_.norm() < options_.baseline_m) {
    if (age_s > kLongestWay_s) begin();
    return;
  }
  // The error of the way is common to all points, so that they are one measurement with their mean
  // information; that of the points is their own.
  double information = 0, weighted = 0;
  const double way_sigma = options_.velocity_sigma_m_s * age_s;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Eigen::Vector2d h = then_[i] * way_.z() - way_.head<2>();
    const double variance = static_cast<double>(s.size()) * std::pow(inverse_ * way_sigma, 2) +
                            2 * std::pow(options_.image_sigma, 2);
    information += h.squaredNorm() / variance;
    weighted += h.dot(s[i] - then_[i] - inverse_ * h) / variance;
  }
  variance_ = 1 / (1 / variance_ + information);
  inverse_ = std::clamp(inverse_ + variance_ * weighted, 1 / kMaxDepth_m, 1 / kMinDepth_m);
  begin();
}

double PlaneDepth::sigma_m() const { return std::sqrt(variance_) / (inverse_ * inverse_); }

}  // namespace kestrel::control
