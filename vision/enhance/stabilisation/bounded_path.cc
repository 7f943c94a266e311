// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/bounded_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace kestrel::vision {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// What the rest of an endless path without bounds costs, as a quadratic form of the two places before it.
Eigen::Matrix2d CostToGo(double lambda) {
  Eigen::Matrix2d P = Eigen::Matrix2d::Zero();
  constexpr int kMost = 2000;
  for (int i = 0; i < kMost; ++i) {
    // Of (d[-2], d[-1], d[0]): d[0]^2 + lambda (d[0] - 2 d[-1] + d[-2])^2 + the rest, the least over d[0].
    Eigen::Matrix3d C = lambda * Eigen::Vector3d(1, -2, 1) * Eigen::RowVector3d(1, -2, 1);
    C(2, 2) += 1;
    C.bottomRightCorner<2, 2>() += P;
    const Eigen::Matrix2d next =
        C.topLeftCorner<2, 2>() - C.topRightCorner<2, 1>() * C.bottomLeftCorner<1, 2>() / C(2, 2);
    const bool done = (next - P).norm() < 1e-9 * next.norm();
    P = next;
    if (done) break;
  }
  return P;
}

}  // namespace

VectorXd BoundedPath(const VectorXd& lower, const VectorXd& upper, const std::array<double, 2>& last,
                     double cutoff) {
  const int n = static_cast<int>(lower.size());
  const double lambda = std::pow(2 * std::sin(std::numbers::pi * cutoff), -4);
  MatrixXd D = MatrixXd::Zero(n, n);
  VectorXd before = VectorXd::Zero(n);  // of the differences, what the last places are of them
  for (int i = 0; i < n; ++i) {
    D(i, i) = 1;
    if (i > 0) D(i, i - 1) = -2;
    if (i > 1) D(i, i - 2) = 1;
  }
  before(0) = last[0] - 2 * last[1];
  if (n > 1) before(1) = last[1];
  MatrixXd Q = MatrixXd::Identity(n, n) + lambda * D.transpose() * D;
  if (n > 1) Q.bottomRightCorner<2, 2>() += CostToGo(lambda);
  const VectorXd c = lambda * D.transpose() * before;
  VectorXd d = Q.ldlt().solve(-c);
  if ((d.array() >= lower.array()).all() && (d.array() <= upper.array()).all()) return d;

  constexpr double kThin = 1e-3, kDone = 1e-10;
  constexpr int kSteps = 60;
  const ArrayXd middle = (lower + upper).array() / 2, half = ((upper - lower).array() / 2).max(kThin),
                low = middle - half, high = middle + half;
  ArrayXd x = d.array().max(low + 0.1 * half).min(high - 0.1 * half);
  ArrayXd a = x - low, b = high - x;  // slacks, which stay positive
  const double scale = Q.cwiseAbs().maxCoeff();
  ArrayXd y = ArrayXd::Constant(n, 0.01 * scale), z = y;  // multipliers of the lower and the upper bounds
  for (int step = 0; step < kSteps; ++step) {
    const double gap = (a * y + b * z).sum() / (2 * n);
    if (gap < kDone * scale) break;
    const double target = 0.2 * gap;
    // (Q + Y/A + Z/B) dx = -(Q x + c) + target / a - target / b
    MatrixXd M = Q;
    M.diagonal() += (y / a + z / b).matrix();
    const VectorXd right = -(Q * x.matrix() + c) + (target / a - target / b).matrix();
    const ArrayXd dx = M.ldlt().solve(right).array();
    const ArrayXd dy = (target - y * dx) / a - y, dz = (target + z * dx) / b - z;
    double t = 1;
    for (int i = 0; i < n; ++i) {
      if (dx(i) < 0) t = std::min(t, -0.99 * a(i) / dx(i));
      if (dx(i) > 0) t = std::min(t, 0.99 * b(i) / dx(i));
      if (dy(i) < 0) t = std::min(t, -0.99 * y(i) / dy(i));
      if (dz(i) < 0) t = std::min(t, -0.99 * z(i) / dz(i));
    }
    x += t * dx, a += t * dx, b -= t * dx, y += t * dy, z += t * dz;
  }
  return x.matrix();
}

}  // namespace kestrel::vision
