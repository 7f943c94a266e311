// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/warp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

const std::vector<WarpModel> kModels{WarpModel::kTranslation, WarpModel::kEuclidean, WarpModel::kSimilarity,
                                     WarpModel::kAffine, WarpModel::kHomography};
const std::vector<Vector2d> kPoints{{0, 0}, {1, 0}, {-0.4, 0.9}, {0.7, -1}};

// Deviating in every parameter that the model has.
WarpParameters SomeParameters(WarpModel model) {
  WarpParameters p = kNoWarp, some;
  some << 0.2, -0.1, 0.15, 0.1, -0.07, 0.12, 0.05, -0.08;
  p.head(ParameterCount(model)) = some.head(ParameterCount(model));
  return p;
}

WarpDerivative Numeric(const std::function<Matrix3d(const WarpParameters&)>& warp, const WarpParameters& p,
                       const Vector2d& x) {
  constexpr double h = 1e-6;
  WarpDerivative d;
  for (int i = 0; i < 8; ++i) {
    const WarpParameters by = h * WarpParameters::Unit(i);
    const Vector2d more = (warp(p + by) * x.homogeneous()).hnormalized(),
                   less = (warp(p - by) * x.homogeneous()).hnormalized();
    d.col(i) = (more - less) / (2 * h);
  }
  return d;
}

TEST(Warp, DerivativesAreThoseOfDifferences) {
  int checked = 0;
  for (const Vector2d& x : kPoints) {
    EXPECT_LT((ExponentialDerivative(x) - Numeric(ExponentialWarp, kNoWarp, x)).norm(), 1e-8);
    for (const WarpModel model : kModels) {
      const auto additive = [&](const WarpParameters& p) { return AdditiveWarp(model, p); };
      const int n = ParameterCount(model);
      for (const WarpParameters& p : {kNoWarp, SomeParameters(model)}) {
        const WarpDerivative off = AdditiveDerivative(model, p, x) - Numeric(additive, p, x);
        EXPECT_LT(off.leftCols(n).norm(), 1e-8) << n;
        ++checked;
      }
      const Matrix3d W = AdditiveWarp(model, SomeParameters(model));
      constexpr double h = 1e-6;
      for (int i = 0; i < 2; ++i) {
        const Vector2d more = (W * (x + h * Vector2d::Unit(i)).homogeneous()).hnormalized(),
                       less = (W * (x - h * Vector2d::Unit(i)).homogeneous()).hnormalized();
        EXPECT_LT((PlaceDerivative(W, x).col(i) - (more - less) / (2 * h)).norm(), 1e-8);
      }
    }
  }
  EXPECT_EQ(checked, 40);
}

TEST(Warp, TheExponentialIsThatOfTheLieAlgebra) {
  for (const double size : {0.01, 1.0, 5.0}) {
    const WarpParameters p = size * SomeParameters(WarpModel::kHomography);
    Matrix3d G;  // the columns of ExponentialDerivative() as vector fields, with any trace
    G << p[3] + p[4], p[5] - p[2], p[0], p[5] + p[2], p[3] - p[4], p[1], -p[6], -p[7], 0;
    Matrix3d exact = G.exp();
    exact /= exact(2, 2);
    EXPECT_LT((ExponentialWarp(p) - exact).norm(), 1e-10 * exact.norm()) << size;
    Matrix3d back = ExponentialWarp(-p) * ExponentialWarp(p);
    back /= back(2, 2);
    EXPECT_LT((back - Matrix3d::Identity()).norm(), 1e-10) << size;
  }
}

TEST(Warp, EachModelKeepsWhatItShould) {
  const auto exponential = [](WarpModel model) { return ExponentialWarp(SomeParameters(model)); };
  const auto additive = [](WarpModel model) { return AdditiveWarp(model, SomeParameters(model)); };
  for (const auto& of : std::vector<std::function<Matrix3d(WarpModel)>>{exponential, additive}) {
    for (const WarpModel model :
         {WarpModel::kTranslation, WarpModel::kEuclidean, WarpModel::kSimilarity, WarpModel::kAffine}) {
      const Matrix3d W = of(model);
      EXPECT_LT((W.row(2) - Eigen::RowVector3d(0, 0, 1)).norm(), 1e-12);  // parallels
      const Eigen::Matrix2d A = W.topLeftCorner<2, 2>(), AA = A.transpose() * A;
      if (model == WarpModel::kAffine) continue;
      EXPECT_LT(std::abs(AA(0, 0) - AA(1, 1)) + std::abs(AA(0, 1)), 1e-12);  // angles
      if (model == WarpModel::kSimilarity) continue;
      EXPECT_NEAR(A.determinant(), 1, 1e-12);  // lengths
      if (model == WarpModel::kEuclidean) continue;
      EXPECT_LT((A - Eigen::Matrix2d::Identity()).norm(), 1e-12);  // directions
    }
  }
}

}  // namespace
}  // namespace kestrel::vision
