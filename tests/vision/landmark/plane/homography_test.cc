// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/plane/homography.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  Vector2d Noise(double sigma) { return {sigma * Normal(), sigma * Normal()}; }
  // A pixel of a 640 x 480 image.
  Vector2d Pixel() { return {640 * unit_(rng_), 480 * unit_(rng_)}; }
  // Turns, stretches and tilts such an image, and never brings its horizon into it.
  Matrix3d Homography() {
    Matrix3d H;
    H << 1 + 0.2 * Normal(), 0.3 * Normal(), 80 * Normal(),  //
        0.3 * Normal(), 1 + 0.2 * Normal(), 80 * Normal(),   //
        2e-4 * std::tanh(Normal()), 2e-4 * std::tanh(Normal()), 1;
    return std::abs(H.determinant()) > 0.3 ? H : Homography();
  }
  std::vector<PointPair> Pairs(const Matrix3d& H, int count, double sigma = 0) {
    std::vector<PointPair> pairs;
    for (int i = 0; i < count; ++i) {
      const Vector2d from = Pixel();
      pairs.push_back({from, Transfer(H, from) + Noise(sigma)});
    }
    return pairs;
  }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_;
};

// The greatest distance, px, between where two homographies take the points of an image.
double Difference(const Matrix3d& A, const Matrix3d& B) {
  double most = 0;
  for (double x = 0; x <= 640; x += 80) {
    for (double y = 0; y <= 480; y += 80)
      most = std::max(most, (Transfer(A, {x, y}) - Transfer(B, {x, y})).norm());
  }
  return most;
}

double Rms(const Matrix3d& H, const std::vector<PointPair>& pairs) {
  double sum = 0;
  for (const PointPair& pair : pairs) sum += (Transfer(H, pair.from) - pair.to).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

// Replaces the first `count` pairs by nonsense.
void Spoil(Random& random, int count, std::vector<PointPair>& pairs) {
  for (int i = 0; i < count; ++i) pairs[i] = {random.Pixel(), random.Pixel()};
}

TEST(Transfer, DividesByTheThirdCoordinate) {
  Matrix3d H;
  H << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  EXPECT_LT((Transfer(H, {2, 0}) - Vector2d(5, 14) / 23).norm(), 1e-15);
  EXPECT_LT((Transfer(H, {1, 1}) - Vector2d(6, 15) / 24).norm(), 1e-15);
}

TEST(FitHomography, FourExactPairsGiveTheHomographyBack) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Matrix3d H = random.Homography();
    std::vector<PointPair> pairs;
    for (const Vector2d& corner :
         {Vector2d(50, 50), Vector2d(600, 40), Vector2d(620, 450), Vector2d(30, 430)}) {
      const Vector2d from = corner + random.Noise(20);
      pairs.push_back({from, Transfer(H, from)});
    }
    const auto fitted = FitHomography(pairs);
    ASSERT_TRUE(fitted) << i;
    EXPECT_LT(Difference(*fitted, H), 1e-6) << i;
    EXPECT_NEAR(fitted->norm(), 1, 1e-12);
  }
}

TEST(FitHomography, ManyExactPairsGiveTheHomographyBack) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Matrix3d H = random.Homography();
    const auto fitted = FitHomography(random.Pairs(H, 5 + i % 40));
    ASSERT_TRUE(fitted) << i;
    // the normal matrix squares the condition, so few badly spread points leave half the digits
    EXPECT_LT(Difference(*fitted, H), 1e-2) << i;
    EXPECT_NEAR(fitted->norm(), 1, 1e-12);
  }
}

TEST(FitHomography, AVanishingLowerRightElementIsNoSpecialCase) {
  Matrix3d H;
  H << 1, 0.2, 30, -0.1, 1.1, 20, 0.004, 0.005, 0;
  const std::vector<Vector2d> from = {{20, 30}, {90, 25}, {100, 110}, {15, 95}, {60, 70}, {40, 50}};
  std::vector<PointPair> pairs;
  for (const Vector2d& x : from) pairs.push_back({x, Transfer(H, x)});
  for (const std::size_t count : {4u, 6u}) {
    const auto fitted = FitHomography(std::span(pairs).first(count));
    ASSERT_TRUE(fitted);
    EXPECT_NEAR((*fitted)(2, 2), 0, 1e-8);
    for (const PointPair& pair : pairs) EXPECT_LT((Transfer(*fitted, pair.from) - pair.to).norm(), 1e-6);
  }
}

// OpenCV goes on from the algebraic solution to the least transfer error, so both agree far within the noise
// only.
TEST(FitHomography, AgreesWithOpenCvOnNoisyPairs) {
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const Matrix3d H = random.Homography();
    const std::vector<PointPair> pairs = random.Pairs(H, 60, 0.5);
    std::vector<cv::Point2d> from, to;
    for (const PointPair& pair : pairs) {
      from.emplace_back(pair.from.x(), pair.from.y());
      to.emplace_back(pair.to.x(), pair.to.y());
    }
    Matrix3d oracle;
    cv::cv2eigen(cv::findHomography(from, to), oracle);
    const auto fitted = FitHomography(pairs);
    ASSERT_TRUE(fitted);
    EXPECT_LT(Difference(*fitted, oracle), 0.15 * Difference(*fitted, H) + 0.1) << i;
    EXPECT_LT(Rms(*fitted, pairs), 1.002 * Rms(oracle, pairs)) << i;
    EXPECT_GE(Rms(*fitted, pairs), (1 - 1e-9) * Rms(oracle, pairs)) << i;
  }
}

// Without Hartley's normalisation the algebraic error, and so the answer, would depend on the choice of
// coordinates.
TEST(FitHomography, DoesNotDependOnOriginAndScaleOfTheCoordinates) {
  Random random(4);
  const std::vector<PointPair> pairs = random.Pairs(random.Homography(), 20, 3.0);
  const auto plain = FitHomography(pairs);
  ASSERT_TRUE(plain);
  Matrix3d A, B;
  A << 0.002, 0, -3, 0, 0.002, 5, 0, 0, 1;
  B << 40, 0, 900, 0, 40, -2000, 0, 0, 1;
  std::vector<PointPair> moved;
  for (const PointPair& pair : pairs) moved.push_back({Transfer(A, pair.from), Transfer(B, pair.to)});
  const auto fitted = FitHomography(moved);
  ASSERT_TRUE(fitted);
  EXPECT_LT(Difference(B.inverse() * *fitted * A, *plain), 1e-5);
}

TEST(FitHomography, RefusesFewerThanFourPairs) {
  Random random(5);
  const std::vector<PointPair> pairs = random.Pairs(random.Homography(), 4);
  for (std::size_t count = 0; count < 4; ++count) EXPECT_FALSE(FitHomography(std::span(pairs).first(count)));
}

TEST(FitHomography, RefusesCollinearPoints) {
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d H = random.Homography();
    const Vector2d start = random.Pixel(), along = random.Noise(1).normalized();
    std::vector<PointPair> pairs;
    for (int k = 0; k < 20; ++k) {
      const Vector2d from = start + 15 * k * along;
      pairs.push_back({from, Transfer(H, from)});
    }
    EXPECT_FALSE(FitHomography(pairs)) << i;
    EXPECT_FALSE(FitHomography(std::span(pairs).first(4))) << i;
    EXPECT_FALSE(FitHomography(std::span(pairs).first(5))) << i;
  }
}

TEST(FitHomography, RefusesFourPairsOfWhichThreeAreCollinear) {
  Random random(7);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d H = random.Homography();
    const Vector2d a = random.Pixel(), b = random.Pixel();
    std::vector<PointPair> pairs;
    for (const Vector2d& from : {a, b, Vector2d(0.3 * a + 0.7 * b), random.Pixel()}) {
      pairs.push_back({from, Transfer(H, from)});
    }
    EXPECT_FALSE(FitHomography(pairs)) << i;
    std::swap(pairs[0], pairs[3]);
    EXPECT_FALSE(FitHomography(pairs)) << i;
    pairs[1].to = random.Pixel();  // a line that the image does not show as one
    EXPECT_FALSE(FitHomography(pairs)) << i;
  }
}

TEST(FitHomography, RefusesFewerThanFourDistinctPoints) {
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    const std::vector<PointPair> three = random.Pairs(random.Homography(), 3);
    std::vector<PointPair> pairs = three;
    pairs.push_back(three[i % 3]);
    EXPECT_FALSE(FitHomography(pairs)) << i;
    for (int k = 0; k < 9; ++k) pairs.push_back(three[k % 3]);
    EXPECT_FALSE(FitHomography(pairs)) << i;
  }
  EXPECT_FALSE(FitHomography(std::vector<PointPair>(4, PointPair{{10, 20}, {30, 40}})));
  EXPECT_FALSE(FitHomography(std::vector<PointPair>(9, PointPair{{10, 20}, {30, 40}})));
}

TEST(FitHomography, RefusesNumbersThatAreNone) {
  Random random(9);
  for (const int count : {4, 12}) {
    std::vector<PointPair> pairs = random.Pairs(Matrix3d::Identity(), count);
    pairs[1].to.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(FitHomography(pairs));
  }
}

class RansacShare : public ::testing::TestWithParam<int> {};

TEST_P(RansacShare, FindsTheTruthAndExactlyTheGoodPairs) {
  Random random(10);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d H = random.Homography();
    std::vector<PointPair> pairs = random.Pairs(H, 100, 0.2);
    Spoil(random, GetParam(), pairs);
    const auto robust = RansacHomography(pairs, {.confidence = 0.9999, .max_trials = 3000}, 1 + i);
    ASSERT_TRUE(robust) << i;
    std::vector<int> good;
    const Matrix3d H_inverse = H.inverse();
    for (int k = 0; k < 100; ++k) {  // a spoilt pair may agree by chance
      const double forward = (Transfer(H, pairs[k].from) - pairs[k].to).norm();
      const double back = (Transfer(H_inverse, pairs[k].to) - pairs[k].from).norm();
      if (std::hypot(forward, back) < 1.7) good.push_back(k);
    }
    EXPECT_TRUE(std::includes(robust->inliers.begin(), robust->inliers.end(), good.begin(), good.end())) << i;
    EXPECT_LE(robust->inliers.size(), good.size() + 1) << i;
    EXPECT_LT(Difference(robust->H, H), 1.5) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Outliers, RansacShare, ::testing::Values(0, 30, 50, 70));

TEST(RansacHomography, SaysNoneWhereTooFewPairsAgree) {
  Random random(11);
  for (int i = 0; i < 20; ++i) {
    std::vector<PointPair> pairs = random.Pairs(random.Homography(), 60, 0.2);
    Spoil(random, 54, pairs);
    EXPECT_FALSE(RansacHomography(pairs, {.min_inliers = 9}, 1 + i)) << i;
    Spoil(random, 60, pairs);
    EXPECT_FALSE(RansacHomography(pairs, {.min_inliers = 8}, 1 + i)) << i;
  }
}

TEST(RansacHomography, NeedsAsManyPairsAsItsConsensus) {
  Random random(12);
  const std::vector<PointPair> pairs = random.Pairs(random.Homography(), 12);
  EXPECT_TRUE(RansacHomography(pairs, {.min_inliers = 12}));
  EXPECT_FALSE(RansacHomography(std::span(pairs).first(11), {.min_inliers = 12}));
  EXPECT_FALSE(RansacHomography(std::span(pairs).first(3), {.min_inliers = 1}));
  EXPECT_FALSE(RansacHomography({}, {}));
}

// Under a magnification by 2 a point that is off by e in the image is off by e/2 in the other: e sqrt(1.25)
// in all.
TEST(RansacHomography, AgreesUpToTheSymmetricTransferDistance) {
  Random random(13);
  Matrix3d H = Matrix3d::Identity();
  H.topLeftCorner<2, 2>() *= 2;
  std::vector<PointPair> pairs = random.Pairs(H, 400);
  const double limit = 2 / std::sqrt(1.25);
  pairs.push_back({{320, 240}, {640, 480 + 0.98 * limit}});
  pairs.push_back({{320, 240}, {640 + 1.02 * limit, 480}});
  const auto robust = RansacHomography(pairs, {.threshold = 2});
  ASSERT_TRUE(robust);
  EXPECT_EQ(robust->inliers.size(), 401u);
  EXPECT_EQ(robust->inliers.back(), 400);
  EXPECT_TRUE(std::is_sorted(robust->inliers.begin(), robust->inliers.end()));
}

TEST(RansacHomography, ReportsTheForwardDistanceOfItsInliers) {
  Random random(14);
  std::vector<PointPair> pairs = random.Pairs(random.Homography(), 80, 0.4);
  Spoil(random, 20, pairs);
  const auto robust = RansacHomography(pairs, {});
  ASSERT_TRUE(robust);
  std::vector<PointPair> inliers;
  for (const int i : robust->inliers) inliers.push_back(pairs[i]);
  EXPECT_NEAR(robust->rms, Rms(robust->H, inliers), 1e-12);
  EXPECT_NEAR(robust->rms, 0.4 * std::sqrt(2), 0.1);  // two coordinates
}

TEST(RansacHomography, TakesNumbersThatAreNoneForOutliers) {
  Random random(15);
  const Matrix3d H = random.Homography();
  std::vector<PointPair> pairs = random.Pairs(H, 60);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 20; i += 2) {
    pairs[i].to = {nan, 3};
    pairs[i + 1].from = {4, nan};
  }
  const auto robust = RansacHomography(pairs, {});
  ASSERT_TRUE(robust);
  EXPECT_EQ(robust->inliers.size(), 40u);
  EXPECT_EQ(robust->inliers.front(), 20);
  EXPECT_LT(Difference(robust->H, H), 1e-3);
}

TEST(RansacHomography, TheSameSeedGivesTheSameBits) {
  Random random(16);
  std::vector<PointPair> pairs = random.Pairs(random.Homography(), 100, 0.8);
  Spoil(random, 60, pairs);
  const auto first = RansacHomography(pairs, {}, 5), again = RansacHomography(pairs, {}, 5);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->H, again->H);
  EXPECT_EQ(first->inliers, again->inliers);
  EXPECT_EQ(first->rms, again->rms);
}

}  // namespace
}  // namespace kestrel::vision
