// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibration_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

double SpreadOfTilts(const std::vector<AdjustedView>& views) {
  double least = 1;
  for (const AdjustedView& a : views) {
    for (const AdjustedView& b : views) {
      const Vector3d z = Vector3d::UnitZ();
      least = std::min(least, (a.X_CT.R * z).dot(b.X_CT.R * z));
    }
  }
  return std::acos(std::clamp(least, -1.0, 1.0));
}

double WorstUncertainty(const Calibration& c) {
  constexpr int kCols = 9, kRows = 7;
  double worst = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Vector2d uv(col * (WidthPx(c.camera) - 1.0) / (kCols - 1),
                        row * (HeightPx(c.camera) - 1.0) / (kRows - 1));
      const auto ray = Ray(c.camera, uv);
      Eigen::Matrix2Xd d_all;
      // Beyond what was seen the lens may show nothing; there nobody asks.
      if (!ray || AngleFromAxis(*ray) > c.max_angle_seen_rad || !Project(c.camera, *ray, nullptr, &d_all))
        continue;
      Eigen::Matrix2Xd d(2, static_cast<Eigen::Index>(c.free.size()));
      for (std::size_t i = 0; i < c.free.size(); ++i)
        d.col(static_cast<Eigen::Index>(i)) = d_all.col(c.free[i]);
      worst = std::max(worst, std::sqrt((d * c.covariance * d.transpose()).trace() / 2));
    }
  }
  return worst;
}

double AllowForImages(const Adjustment& adjustment, const std::vector<int>& free, Calibration& c) {
  const auto clustered = ClusteredCovariance(adjustment, free);
  if (!clustered) return 1;
  const Eigen::VectorXd scale = c.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd one = scale.asDiagonal() * c.covariance * scale.asDiagonal();
  const Eigen::MatrixXd other = scale.asDiagonal() * *clustered * scale.asDiagonal();
  const double alike = std::sqrt(one.ldlt().solve(other).trace() / static_cast<double>(free.size()));
  if (alike > kMaxAlike) c.covariance = *clustered;
  return alike;
}

}  // namespace kestrel::vision
