// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/path_weights.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>

namespace kestrel::vision {
namespace {

TEST(PathWeights, AreTheLeastSquaresOfTheirDefinition) {
  constexpr double kCutoff = 0.05;
  const double root = 1 / std::pow(2 * std::sin(std::numbers::pi * kCutoff), 2);  // of lambda, order 2
  constexpr int kBefore = 12, kAfter = 7, kPlaces = kBefore + kAfter + 1;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * kPlaces - 2, kPlaces);
  A.topRows(kPlaces).setIdentity();
  for (int i = 0; i + 2 < kPlaces; ++i)
    A(kPlaces + i, i) = root, A(kPlaces + i, i + 1) = -2 * root, A(kPlaces + i, i + 2) = root;
  const Eigen::VectorXd path = Eigen::VectorXd::LinSpaced(kPlaces, 0, 9).array().sin() * 5;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(A.rows());
  right.head(kPlaces) = path;
  const Eigen::VectorXd smooth = A.colPivHouseholderQr().solve(right);
  EXPECT_NEAR(PathWeights(kBefore, kAfter, kCutoff, 2).dot(path), smooth(kBefore), 1e-9);
}

TEST(PathWeights, LeaveAnEvenPathAsItIs) {
  for (const int before : {0, 1, 5, 40}) {
    for (const int after : {0, 1, 30}) {
      const Eigen::VectorXd weights = PathWeights(before, after, 0.01, 2);
      ASSERT_EQ(weights.size(), before + after + 1);
      EXPECT_NEAR(weights.sum(), 1, 1e-6);
      EXPECT_NEAR(weights.dot(Eigen::VectorXd::LinSpaced(weights.size(), -before, after)), 0, 1e-5);
    }
  }
}

TEST(PathWeights, HalveTheAmplitudeAtTheCutoffAndKeepLittleAboveIt) {
  constexpr int kSide = 400;
  constexpr double kCutoff = 0.01;
  const Eigen::VectorXd weights = PathWeights(kSide, kSide, kCutoff, 2);
  for (const double times : {0.5, 1.0, 3.0}) {
    double gain = 0;
    for (int k = -kSide; k <= kSide; ++k)
      gain += weights(k + kSide) * std::cos(2 * std::numbers::pi * times * kCutoff * k);
    EXPECT_NEAR(gain, 1 / (1 + std::pow(times, 4)), 2e-3) << times;
  }
}

}  // namespace
}  // namespace kestrel::vision
