// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/straighten.h"

#include <Eigen/Dense>

namespace kestrel::vision {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<Matrix3d> Straightening(std::span<const Matrix3d> R_WC) {
  if (R_WC.empty()) return std::nullopt;
  Matrix3d squares = Matrix3d::Zero();
  Vector3d mean_down = Vector3d::Zero();
  for (const Matrix3d& R : R_WC) {
    squares += R.col(0) * R.col(0).transpose() / static_cast<double>(R_WC.size());
    mean_down += R.col(1);
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(squares);
  // That of two axes 30 degrees apart.
  constexpr double kLeastSpread = 0.07, kMostUneven = 0.25;
  if (solver.eigenvalues()(1) < kLeastSpread ||
      solver.eigenvalues()(0) > kMostUneven * solver.eigenvalues()(1))
    return std::nullopt;
  Vector3d down = solver.eigenvectors().col(0);
  if (down.dot(mean_down) < 0) down = -down;
  const Vector3d ahead = R_WC.front().col(2) - down * down.dot(R_WC.front().col(2));
  if (ahead.norm() < 0.1) return std::nullopt;  // it looks up or down
  Matrix3d R_VW;
  R_VW.row(1) = down.transpose();
  R_VW.row(2) = ahead.normalized().transpose();
  R_VW.row(0) = R_VW.row(1).cross(R_VW.row(2));
  return R_VW;
}

}  // namespace kestrel::vision
