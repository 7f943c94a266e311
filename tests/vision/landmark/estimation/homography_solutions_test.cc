// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/homography_solutions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <vector>

#include "tests/vision/landmark/estimation/drawn_pairs.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Fit = std::optional<Matrix3d> (*)(std::span<const PointPair>);

std::optional<Matrix3d> FitSymmetric(std::span<const PointPair> pairs) {
  return FitGeometric(pairs, GeometricError::kSymmetricTransfer);
}
std::optional<Matrix3d> FitSampson(std::span<const PointPair> pairs) {
  return FitGeometric(pairs, GeometricError::kSampson);
}
const std::vector<Fit> kFits = {FitInhomogeneous, FitHomography, FitSymmetric, FitSampson};

TEST(HomographySolutions, ExactPairsGiveTheHomographyBack) {
  DrawnPairs random(21);
  for (int i = 0; i < 40; ++i) {
    const Matrix3d H = random.Homography();
    for (const int count : {4, 8, 40}) {
      const std::vector<PointPair> pairs = random.Spread(H, count);
      for (const Fit fit : kFits) {
        const auto fitted = fit(pairs);
        ASSERT_TRUE(fitted) << i;
        EXPECT_LT(Difference(*fitted, H), 1e-4) << i << ' ' << count;
        EXPECT_NEAR(fitted->norm(), 1, 1e-12);
      }
    }
  }
}

// OpenCV goes on to the least forward error; so do none of these, and all are equal far within the noise.
TEST(HomographySolutions, AgreeWithOpenCvOnNoisyPairs) {
  DrawnPairs random(22);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d H = random.Homography();
    const std::vector<PointPair> pairs = random.Spread(H, 60, 0.5);
    Matrix3d oracle;
    cv::cv2eigen(cv::findHomography(FromOf(pairs), ToOf(pairs)), oracle);
    for (const Fit fit : kFits) {
      const auto fitted = fit(pairs);
      ASSERT_TRUE(fitted);
      EXPECT_LT(Difference(*fitted, oracle), 0.5 * Difference(*fitted, H) + 0.3) << i;
    }
  }
}

TEST(HomographySolutions, ThePseudoInverseSolvesTheNormalEquations) {
  DrawnPairs random(23);
  const std::vector<PointPair> pairs = random.Spread(random.Homography(), 12, 2);
  const auto fitted = FitInhomogeneous(pairs);
  ASSERT_TRUE(fitted);
  // By its definition, in coordinates of the centroid: A'(A h - b) = 0 for h33 = 1.
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const PointPair& pair : pairs) from += pair.from / 12, to += pair.to / 12;
  double spread_from = 0, spread_to = 0;
  for (const PointPair& pair : pairs)
    spread_from += (pair.from - from).squaredNorm() / 12, spread_to += (pair.to - to).squaredNorm() / 12;
  Matrix3d n_from, n_to;
  const double a = std::sqrt(2 / spread_from), b = std::sqrt(2 / spread_to);
  n_from << a, 0, -a * from.x(), 0, a, -a * from.y(), 0, 0, 1;
  n_to << b, 0, -b * to.x(), 0, b, -b * to.y(), 0, 0, 1;
  Matrix3d h = n_to * *fitted * n_from.inverse();
  h /= h(2, 2);
  Eigen::Matrix<double, 8, 1> gradient = Eigen::Matrix<double, 8, 1>::Zero();
  for (const PointPair& pair : pairs) {
    const Vector2d x = Transfer(n_from, pair.from), y = Transfer(n_to, pair.to);
    const Eigen::Vector3d z = h * x.homogeneous();
    const Vector2d error = z.head<2>() - z.z() * y;
    Eigen::Matrix<double, 2, 8> A;
    A << x.x(), x.y(), 1, 0, 0, 0, -x.x() * y.x(), -x.y() * y.x(), 0, 0, 0, x.x(), x.y(), 1, -x.x() * y.y(),
        -x.y() * y.y();
    gradient += A.transpose() * error;
  }
  EXPECT_LT(gradient.norm(), 1e-9);
}

TEST(FitGeometric, NoNeighbourHasALesserSum) {
  DrawnPairs random(24);
  int lesser_than_start = 0;
  for (const GeometricError error : {GeometricError::kSymmetricTransfer, GeometricError::kSampson}) {
    for (int i = 0; i < 10; ++i) {
      const std::vector<PointPair> pairs = random.Spread(random.Homography(), 12, 2);
      const auto fitted = FitGeometric(pairs, error);
      ASSERT_TRUE(fitted);
      const double least = SumOfSquares(pairs, *fitted, error);
      lesser_than_start += least < (1 - 1e-6) * SumOfSquares(pairs, *FitHomography(pairs), error);
      for (int k = 0; k < 9; ++k) {
        for (const double step : {1e-5, -1e-5}) {
          Matrix3d moved = *fitted;
          moved(k / 3, k % 3) *= 1 + step;
          EXPECT_GE(SumOfSquares(pairs, moved, error), least * (1 - 1e-9)) << k;
        }
      }
    }
  }
  EXPECT_GE(lesser_than_start, 18);
}

// By its definition: the least distance in all four coordinates from what H allows, found by moving x.
TEST(SumOfSquares, SampsonsIsNearlyTheDistanceFromWhatTheHomographyAllows) {
  DrawnPairs random(25);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d H = random.Homography();
    const std::vector<PointPair> pairs = random.Spread(H, 4, 0.5);
    for (const PointPair& pair : pairs) {
      Vector2d x = pair.from;
      for (int step = 0; step < 20; ++step) {  // Gauss-Newton with a numeric derivative
        constexpr double kStep = 1e-4;
        Eigen::Matrix2d J;
        for (int k = 0; k < 2; ++k)
          J.col(k) =
              (Transfer(H, x + kStep * Vector2d::Unit(k)) - Transfer(H, x - kStep * Vector2d::Unit(k))) /
              (2 * kStep);
        const Vector2d g = (pair.from - x) + J.transpose() * (pair.to - Transfer(H, x));
        x += (Eigen::Matrix2d::Identity() + J.transpose() * J).inverse() * g;
      }
      const double least = (pair.from - x).squaredNorm() + (pair.to - Transfer(H, x)).squaredNorm();
      EXPECT_NEAR(SumOfSquares(std::span(&pair, 1), H, GeometricError::kSampson), least, 1e-2 * least + 1e-9);
    }
  }
}

// With noise on one side, the forward error would be the likeliest; the symmetric one is worse by little, and the
// algebraic ones by no less than it, over many draws.
TEST(FitGeometric, IsNoWorseThanTheAlgebraicSolutions) {
  DrawnPairs random(26);
  double inhomogeneous = 0, homogeneous = 0, symmetric = 0, sampson = 0;
  constexpr int kDraws = 150;
  for (int i = 0; i < kDraws; ++i) {
    const Matrix3d H = random.Homography();
    std::vector<PointPair> pairs = random.Spread(H, 10, 1);
    for (PointPair& pair : pairs) pair.from += random.Noise(1);
    inhomogeneous += Difference(*FitInhomogeneous(pairs), H) / kDraws;
    homogeneous += Difference(*FitHomography(pairs), H) / kDraws;
    symmetric += Difference(*FitSymmetric(pairs), H) / kDraws;
    sampson += Difference(*FitSampson(pairs), H) / kDraws;
  }
  EXPECT_LT(sampson, 1.01 * homogeneous);
  EXPECT_LT(sampson, 1.01 * symmetric);
  EXPECT_LT(sampson, 1.01 * inhomogeneous);
  RecordProperty("px", std::to_string(inhomogeneous) + ' ' + std::to_string(homogeneous) + ' ' +
                           std::to_string(symmetric) + ' ' + std::to_string(sampson));
}

TEST(HomographySolutions, RefuseSetsThatLeaveItOpen) {
  DrawnPairs random(27);
  for (int i = 0; i < 10; ++i) {
    const Matrix3d H = random.Homography();
    const Vector2d a = random.Pixel(), b = random.Pixel();
    const auto paired = [&](const std::vector<Vector2d>& points) {
      std::vector<PointPair> pairs;
      for (const Vector2d& x : points) pairs.push_back({x, Transfer(H, x)});
      return pairs;
    };
    std::vector<Vector2d> line;
    for (int k = 0; k < 9; ++k) line.push_back(a + k / 8.0 * (b - a));
    std::vector<Vector2d> all_but_one = line;
    all_but_one.push_back(random.Pixel());
    for (const Fit fit : kFits) {
      EXPECT_FALSE(fit(paired({a, b, 0.3 * a + 0.7 * b, random.Pixel()})));  // three on a line
      EXPECT_FALSE(fit(paired(line)));
      EXPECT_FALSE(fit(paired(all_but_one)));
      EXPECT_FALSE(fit(paired({a, b, random.Pixel(), a})));  // coincident
      EXPECT_FALSE(fit(paired(std::vector<Vector2d>(7, a))));
      EXPECT_FALSE(fit(paired({a, b, random.Pixel()})));
      std::vector<PointPair> broken = random.Spread(H, 9);
      broken[2].from.x() = std::numeric_limits<double>::quiet_NaN();
      EXPECT_FALSE(fit(broken));
    }
  }
}

}  // namespace
}  // namespace kestrel::vision
