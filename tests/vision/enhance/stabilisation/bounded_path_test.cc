// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/bounded_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::vision {
namespace {

using Eigen::VectorXd;

constexpr int kPlaces = 40;
constexpr double kCutoff = 0.02;

TEST(BoundedPath, StaysAtNothingWhereNothingForcesIt) {
  const VectorXd path =
      BoundedPath(VectorXd::Constant(kPlaces, -1), VectorXd::Constant(kPlaces, 1), {0, 0}, kCutoff);
  EXPECT_EQ(path.norm(), 0);
}

// Against projected coordinate descent on the same function, over a tail so long that the rest is nothing.
TEST(BoundedPath, IsTheLeastOfItsDefinition) {
  VectorXd lower = VectorXd::Constant(kPlaces, -30), upper = VectorXd::Constant(kPlaces, 30);
  lower.segment(20, 3).setConstant(5);
  upper.segment(30, 2).setConstant(2);
  const VectorXd path = BoundedPath(lower, upper, {0.1, 0.2}, kCutoff);
  for (int i = 0; i < kPlaces; ++i) EXPECT_TRUE(path(i) > lower(i) - 1e-6 && path(i) < upper(i) + 1e-6) << i;
  EXPECT_NEAR(path(20), 5, 1);
  // With the tail as it goes on without bounds, no change of one or two neighbouring places within them is better.
  const auto cost = [&](const VectorXd& of) {
    const double lambda = std::pow(2 * std::sin(std::numbers::pi * kCutoff), -4);
    double before = 0.1, last = 0.2, sum = 0;
    for (int i = 0; i < kPlaces; ++i) {
      sum += of(i) * of(i) + lambda * std::pow(of(i) - 2 * last + before, 2);
      before = last, last = of(i);
    }
    const VectorXd tail =
        BoundedPath(VectorXd::Constant(400, -1e6), VectorXd::Constant(400, 1e6), {before, last}, kCutoff);
    for (int i = 0; i < 400; ++i) {
      sum += tail(i) * tail(i) + lambda * std::pow(tail(i) - 2 * last + before, 2);
      before = last, last = tail(i);
    }
    return sum;
  };
  const double least = cost(path);
  for (int i = 0; i < kPlaces; i += 3) {
    for (const double step : {-0.05, 0.05}) {
      VectorXd other = path;
      other(i) += step;
      if (other(i) < lower(i) || other(i) > upper(i)) continue;
      EXPECT_GT(cost(other), least - 1e-6 * least) << i;
    }
  }
}

TEST(BoundedPath, BoundsThatExcludeOneAnotherGiveTheirMean) {
  VectorXd lower = VectorXd::Constant(kPlaces, -30), upper = VectorXd::Constant(kPlaces, 30);
  lower(10) = 4, upper(10) = 2;
  EXPECT_NEAR(BoundedPath(lower, upper, {0, 0}, kCutoff)(10), 3, 0.01);
}

}  // namespace
}  // namespace kestrel::vision
