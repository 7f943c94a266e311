// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibration_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/pose.h"

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
  // Of the pixels of some rays, two rows each: by the parameters, and by a turn of the camera.
  Eigen::MatrixXd d_parameters(0, static_cast<Eigen::Index>(c.free.size()));
  Eigen::MatrixX3d d_turn(0, 3);
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Vector2d uv(col * (WidthPx(c.camera) - 1.0) / (kCols - 1),
                        row * (HeightPx(c.camera) - 1.0) / (kRows - 1));
      const auto ray = Ray(c.camera, uv);
      Eigen::Matrix<double, 2, 3> d_point;
      Eigen::Matrix2Xd d_all;
      // Beyond what was seen the lens may show nothing; there nobody asks.
      if (!ray || AngleFromAxis(*ray) > c.max_angle_seen_rad || !Project(c.camera, *ray, &d_point, &d_all))
        continue;
      const Eigen::Index rows = d_turn.rows();
      d_parameters.conservativeResize(rows + 2, Eigen::NoChange);
      d_parameters.bottomRows<2>() = d_all(Eigen::all, c.free);
      d_turn.conservativeResize(rows + 2, Eigen::NoChange);
      d_turn.bottomRows<2>() = d_point * Skew(*ray);
    }
  }
  if (d_turn.rows() == 0) return 0;
  d_parameters -= d_turn * (d_turn.transpose() * d_turn).ldlt().solve(d_turn.transpose() * d_parameters);
  double worst = 0;
  for (Eigen::Index i = 0; i < d_parameters.rows(); i += 2) {
    const auto d = d_parameters.middleRows<2>(i);
    worst = std::max(worst, std::sqrt((d * c.covariance * d.transpose()).trace() / 2));
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
