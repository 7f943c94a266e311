// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/cubic_spline.h"

#include <algorithm>
#include <utility>

namespace kestrel::flight {

CubicSpline::CubicSpline(std::vector<double> knots, std::vector<Eigen::Vector3d> points)
    : knots_(std::move(knots)),
      points_(std::move(points)),
      curvatures_(points_.size(), Eigen::Vector3d::Zero()) {
  const std::size_t n = knots_.size();
  // The first derivative is continuous: a system of three diagonals, solved by elimination and substitution.
  std::vector<double> above(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = knots_[i] - knots_[i - 1], after = knots_[i + 1] - knots_[i];
    const Eigen::Vector3d right =
        6 * ((points_[i + 1] - points_[i]) / after - (points_[i] - points_[i - 1]) / before);
    const double pivot = 2 * (before + after) - before * above[i - 1];
    above[i] = after / pivot;
    curvatures_[i] = (right - before * curvatures_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvatures_[i] -= above[i] * curvatures_[i + 1];
}

CubicSpline::Point CubicSpline::At(double t) const {
  t = std::clamp(t, knots_.front(), knots_.back());
  const auto next = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
  const auto i = static_cast<std::size_t>(next - knots_.begin());
  const double h = knots_[i] - knots_[i - 1], a = (knots_[i] - t) / h, b = 1 - a;
  const Eigen::Vector3d &p = points_[i - 1], &q = points_[i], &m = curvatures_[i - 1], &k = curvatures_[i];
  return {a * p + b * q + ((a * a * a - a) * m + (b * b * b - b) * k) * (h * h / 6),
          (q - p) / h + ((1 - 3 * a * a) * m + (3 * b * b - 1) * k) * (h / 6), a * m + b * k};
}

}  // namespace kestrel::flight
