// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/distortion/polynomial.h"

#include <gtest/gtest.h>

#include <random>
#include <unsupported/Eigen/Polynomials>

namespace kestrel::vision {
namespace {

double MinPositiveRoot(const std::array<double, 7>& c) {
  Eigen::PolynomialSolver<double, 6> solver(Eigen::Matrix<double, 7, 1>(c.data()));
  double least = std::numeric_limits<double>::infinity();
  for (const auto& root : solver.roots()) {
    if (std::abs(root.imag()) < 1e-9 && root.real() > 0) least = std::min(least, root.real());
  }
  return least;
}

TEST(Polynomial, FirstZeroIsTheLeastPositiveRoot) {
  std::mt19937 rng(3);
  std::normal_distribution<double> coefficient;
  int with_root = 0;
  for (int i = 0; i < 2000; ++i) {
    std::array<double, 7> c{1};
    for (std::size_t k = 1; k < 7; ++k) c[k] = coefficient(rng);
    const double expected = MinPositiveRoot(c), found = FirstZero(c);
    if (std::isinf(expected)) {
      EXPECT_EQ(found, expected);
      continue;
    }
    ++with_root;
    EXPECT_NEAR(found, expected, 1e-6 * expected);  // the roots of the companion matrix are no better
    EXPECT_TRUE(PositiveUpTo(c, 0.999999 * expected));
    EXPECT_FALSE(PositiveUpTo(c, 1.000001 * expected));
    EXPECT_FALSE(PositiveUpTo(c, 10 * expected));  // also where it is positive again
  }
  EXPECT_GT(with_root, 1000);
}

TEST(Polynomial, ThatOnlyComesNearZeroStaysPositive) {
  const std::array<double, 3> touching{1, -2, 1}, above{1.001, -2, 1}, below{0.999, -2, 1};  // (x - 1)^2
  EXPECT_FALSE(PositiveUpTo(touching, 3));
  EXPECT_TRUE(PositiveUpTo(above, 3));
  EXPECT_FALSE(PositiveUpTo(below, 3));
  EXPECT_NEAR(FirstZero(below), 1 - std::sqrt(0.001), 1e-12);
}

}  // namespace
}  // namespace kestrel::vision
