// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/robust_homography.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <vector>

#include "tests/vision/landmark/estimation/drawn_pairs.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;

// Those that agree with the truth within a distance, the spoilt ones among them by chance.
std::vector<int> Agreeing(const Matrix3d& H, const std::vector<PointPair>& pairs, double distance) {
  std::vector<int> good;
  const Matrix3d inverse = H.inverse();
  for (int k = 0; k < static_cast<int>(pairs.size()); ++k) {
    const double forward = (Transfer(H, pairs[k].from) - pairs[k].to).norm();
    const double back = (Transfer(inverse, pairs[k].to) - pairs[k].from).norm();
    if (std::hypot(forward, back) < distance) good.push_back(k);
  }
  return good;
}

struct Estimator {
  const char* name;
  std::optional<RobustHomography> (*estimate)(std::span<const PointPair>, std::uint32_t seed);
  int cv_method;
  int max_outliers;  // of 100
};

std::optional<RobustHomography> Ransac(std::span<const PointPair> pairs, std::uint32_t seed) {
  return RansacHomography(pairs, {.confidence = 0.9999, .max_trials = 3000}, seed);
}
std::optional<RobustHomography> Lmeds(std::span<const PointPair> pairs, std::uint32_t seed) {
  return LmedsHomography(pairs, {}, seed);
}
std::optional<RobustHomography> Msac(std::span<const PointPair> pairs, std::uint32_t seed) {
  return MsacHomography(pairs, {.confidence = 0.9999, .max_trials = 3000}, seed);
}

class EveryEstimator : public ::testing::TestWithParam<Estimator> {};

TEST_P(EveryEstimator, FindsTheTruthAndTheGoodPairsAmongOutliers) {
  const Estimator& e = GetParam();
  DrawnPairs random(31);
  int cases = 0;
  for (const int outliers : {0, 20, 40, 49, 60, 70}) {
    if (outliers > e.max_outliers) continue;
    for (int i = 0; i < 4; ++i) {
      const Matrix3d H = random.Homography();
      std::vector<PointPair> pairs = random.Spread(H, 100, 0.2);
      std::reverse(pairs.begin(), pairs.end());
      random.Spoil(outliers, pairs);
      const auto robust = e.estimate(pairs, 1 + i);
      ASSERT_TRUE(robust) << outliers;
      // three deviations of both sides together, where H keeps sizes about as they are
      const std::vector<int> good = Agreeing(H, pairs, 0.5);
      EXPECT_TRUE(std::includes(robust->inliers.begin(), robust->inliers.end(), good.begin(), good.end()))
          << outliers;
      EXPECT_LE(robust->inliers.size(), Agreeing(H, pairs, 4).size()) << outliers;
      EXPECT_LT(Difference(robust->H, H), 0.8) << outliers;
      ++cases;
    }
  }
  EXPECT_GE(cases, 16);
}

TEST_P(EveryEstimator, ExactPairsGiveTheHomographyBack) {
  const Estimator& e = GetParam();
  DrawnPairs random(32);
  for (int outliers = 0; outliers <= std::min(e.max_outliers, 60); outliers += 15) {
    const Matrix3d H = random.Homography();
    std::vector<PointPair> pairs = random.Spread(H, 100);
    std::reverse(pairs.begin(), pairs.end());
    random.Spoil(outliers, pairs);
    const auto robust = e.estimate(pairs, 3);
    ASSERT_TRUE(robust) << outliers;
    EXPECT_GE(robust->inliers.size(), 100u - outliers);
    if (robust->inliers.size() == 100u - outliers) {
      EXPECT_LT(Difference(robust->H, H), 1e-4) << outliers;
    }
  }
}

// The best of OpenCV's, and that of the same principle: neither sees the truth more clearly by much.
TEST_P(EveryEstimator, IsAboutAsGoodAsOpenCvs) {
  const Estimator& e = GetParam();
  DrawnPairs random(33);
  double ours = 0, same = 0, magsac = 0;
  constexpr int kDraws = 20;
  for (int i = 0; i < kDraws; ++i) {
    const Matrix3d H = random.Homography();
    std::vector<PointPair> pairs = random.Spread(H, 100, 0.5);
    std::reverse(pairs.begin(), pairs.end());
    random.Spoil(40, pairs);
    const auto robust = e.estimate(pairs, 1 + i);
    ASSERT_TRUE(robust);
    ours += Difference(robust->H, H) / kDraws;
    const auto by = [&](int method) {
      Matrix3d found;
      cv::cv2eigen(cv::findHomography(FromOf(pairs), ToOf(pairs), method, 2), found);
      return Difference(found, H) / kDraws;
    };
    same += by(e.cv_method), magsac += by(cv::USAC_MAGSAC);
  }
  EXPECT_LT(ours, 1.3 * same + 0.1);
  EXPECT_LT(ours, 1.3 * magsac + 0.1);
  RecordProperty("px", std::to_string(ours) + ' ' + std::to_string(same) + ' ' + std::to_string(magsac));
}

TEST_P(EveryEstimator, RefusesDegenerateSets) {
  const Estimator& e = GetParam();
  DrawnPairs random(34);
  const Matrix3d H = random.Homography();
  std::vector<PointPair> line, point(20, random.Spread(H, 1)[0]);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector2d x(20 + 30 * k, 400 - 11 * k);
    line.push_back({x, Transfer(H, x)});
  }
  EXPECT_FALSE(e.estimate(line, 1));
  EXPECT_FALSE(e.estimate(point, 1));
  EXPECT_FALSE(e.estimate({}, 1));
  EXPECT_FALSE(e.estimate(random.Spread(H, 7), 1));  // fewer than the inliers that are asked for
}

TEST_P(EveryEstimator, SaysNoneWhereNothingAgrees) {
  DrawnPairs random(35);
  std::vector<PointPair> pairs = random.Spread(random.Homography(), 60);
  random.Spoil(60, pairs);
  for (std::uint32_t seed = 1; seed < 5; ++seed) EXPECT_FALSE(GetParam().estimate(pairs, seed));
}

TEST_P(EveryEstimator, TakesNumbersThatAreNoneForOutliers) {
  DrawnPairs random(36);
  const Matrix3d H = random.Homography();
  std::vector<PointPair> pairs = random.Spread(H, 60);
  std::reverse(pairs.begin(), pairs.end());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 20; i += 2) pairs[i].to = {nan, 3}, pairs[i + 1].from = {4, nan};
  const auto robust = GetParam().estimate(pairs, 1);
  ASSERT_TRUE(robust);
  EXPECT_EQ(robust->inliers.size(), 40u);
  EXPECT_LT(Difference(robust->H, H), 1e-3);
}

TEST_P(EveryEstimator, TheSameSeedGivesTheSameBits) {
  DrawnPairs random(37);
  std::vector<PointPair> pairs = random.Spread(random.Homography(), 100, 0.8);
  std::reverse(pairs.begin(), pairs.end());
  random.Spoil(40, pairs);
  const auto first = GetParam().estimate(pairs, 5), again = GetParam().estimate(pairs, 5);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->H, again->H);
  EXPECT_EQ(first->inliers, again->inliers);
}

INSTANTIATE_TEST_SUITE_P(Homography, EveryEstimator,
                         ::testing::Values(Estimator{"Ransac", Ransac, cv::RANSAC, 70},
                                           Estimator{"Lmeds", Lmeds, cv::LMEDS, 49},
                                           Estimator{"Msac", Msac, cv::RANSAC, 70}),
                         [](const auto& each) { return each.param.name; });

TEST(LmedsHomography, SaysNoneWhereMostPairsAreWrong) {
  DrawnPairs random(38);
  std::vector<PointPair> pairs = random.Spread(random.Homography(), 100, 0.2);
  std::reverse(pairs.begin(), pairs.end());
  random.Spoil(60, pairs);
  EXPECT_FALSE(LmedsHomography(pairs, {}, 1));
}

// It needs no threshold: noise of 3 px is measured as well as that of 0.1 px.
TEST(LmedsHomography, MeasuresTheNoiseItself) {
  DrawnPairs random(39);
  for (const double sigma : {0.1, 1.0, 3.0}) {
    std::vector<PointPair> pairs = random.Spread(Matrix3d::Identity(), 300, sigma);
    std::reverse(pairs.begin(), pairs.end());
    random.Spoil(90, pairs);
    const auto robust = LmedsHomography(pairs, {.max_median_px = 20}, 1);
    ASSERT_TRUE(robust) << sigma;
    EXPECT_GE(robust->inliers.size(), 0.93 * 210) << sigma;
    EXPECT_LE(robust->inliers.size(), 216u) << sigma;
    EXPECT_NEAR(robust->rms, std::sqrt(2) * sigma, 0.15 * sigma);
  }
}

}  // namespace
}  // namespace kestrel::vision
