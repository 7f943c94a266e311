// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/warp.h"

#include <Eigen/Dense>
#include <cmath>

namespace kestrel::vision {
namespace {

// sum p_i G_i, without a trace: the Lie algebra of SL(3).
Eigen::Matrix3d Algebra(const WarpParameters& p) {
  Eigen::Matrix3d G;
  G << p[3] / 3 + p[4], p[5] - p[2], p[0],  //
      p[5] + p[2], p[3] / 3 - p[4], p[1],   //
      -p[6], -p[7], -2 * p[3] / 3;
  return G;
}

}  // namespace

int ParameterCount(WarpModel warp) {
  switch (warp) {
    case WarpModel::kTranslation:
      return 2;
    case WarpModel::kEuclidean:
      return 3;
    case WarpModel::kSimilarity:
      return 4;
    case WarpModel::kAffine:
      return 6;
    case WarpModel::kHomography:
      return 8;
  }
  return 8;
}

// By its series, after halving the argument often enough and squaring as often.
Eigen::Matrix3d ExponentialWarp(const WarpParameters& p) {
  constexpr int kTerms = 10;
  Eigen::Matrix3d G = Algebra(p);
  int halvings = 0;
  for (double norm = G.norm(); norm > 0.25 && halvings < 40; norm /= 2) ++halvings;
  G = std::ldexp(1.0, -halvings) * G;
  Eigen::Matrix3d term = Eigen::Matrix3d::Identity(), sum = term;
  for (int k = 1; k <= kTerms; ++k) {
    term = term * G / k;
    sum += term;
  }
  for (int k = 0; k < halvings; ++k) sum = (sum * sum).eval();
  return sum / sum(2, 2);
}

WarpDerivative ExponentialDerivative(const Eigen::Vector2d& at) {
  const double x = at.x(), y = at.y();
  WarpDerivative d;
  d << 1, 0, -y, x, x, y, x * x, x * y,  //
      0, 1, x, y, -y, x, x * y, y * y;
  return d;
}

Eigen::Matrix3d AdditiveWarp(WarpModel warp, const WarpParameters& p) {
  Eigen::Matrix3d W;
  if (warp == WarpModel::kEuclidean) {
    W << std::cos(p[2]), -std::sin(p[2]), p[0], std::sin(p[2]), std::cos(p[2]), p[1], 0, 0, 1;
  } else {
    W << 1 + p[3] + p[4], p[5] - p[2], p[0], p[5] + p[2], 1 + p[3] - p[4], p[1], -p[6], -p[7], 1;
  }
  return W;
}

WarpDerivative AdditiveDerivative(WarpModel warp, const WarpParameters& p, const Eigen::Vector2d& x) {
  WarpDerivative d = ExponentialDerivative(x);
  if (warp == WarpModel::kEuclidean) {
    const double c = std::cos(p[2]), s = std::sin(p[2]);
    d.col(2) << -s * x.x() - c * x.y(), c * x.x() - s * x.y();
    return d;
  }
  const Eigen::Vector3d q = AdditiveWarp(warp, p) * x.homogeneous();
  const Eigen::Vector2d at = q.hnormalized();
  d.col(6) = x.x() * at, d.col(7) = x.y() * at;  // the denominator falls by x and by y
  return d / q.z();
}

Eigen::Matrix2d PlaceDerivative(const Eigen::Matrix3d& W, const Eigen::Vector2d& x) {
  const Eigen::Vector3d q = W * x.homogeneous();
  return (W.topLeftCorner<2, 2>() - q.hnormalized() * W.bottomLeftCorner<1, 2>()) / q.z();
}

}  // namespace kestrel::vision
