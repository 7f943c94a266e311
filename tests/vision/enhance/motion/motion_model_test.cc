// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/motion_model.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// A motion of each model, in the order of the models.
std::vector<Matrix3d> Motions() {
  const double c = std::cos(0.2), s = std::sin(0.2);
  Matrix3d euclidean, similarity, affine, homography;
  euclidean << c, -s, 12, s, c, -7, 0, 0, 1;
  similarity << 1.3 * c, -1.3 * s, 12, 1.3 * s, 1.3 * c, -7, 0, 0, 1;
  affine << 1.1, 0.2, 5, -0.1, 0.9, 8, 0, 0, 1;
  homography << 1.1, 0.2, 5, -0.1, 0.9, 8, 2e-4, -1e-4, 1;
  return {euclidean, similarity, affine, homography};
}

std::vector<PointPair> Pairs(const Matrix3d& H, double noise_px, int count = 40) {
  cv::RNG any(5);
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Vector2d from(any.uniform(0.0, 640.0), any.uniform(0.0, 480.0));
    const Vector2d to = (H * from.homogeneous()).hnormalized();
    pairs.push_back({from, to + noise_px * Vector2d(any.gaussian(1), any.gaussian(1))});
  }
  return pairs;
}

double SquaredDistance(const std::vector<PointPair>& pairs, const Matrix3d& H) {
  double sum = 0;
  for (const PointPair& pair : pairs)
    sum += ((H * pair.from.homogeneous()).hnormalized() - pair.to).squaredNorm();
  return sum;
}

cv::Mat Points(const std::vector<PointPair>& pairs, bool to) {
  cv::Mat points(static_cast<int>(pairs.size()), 1, CV_64FC2);
  for (int i = 0; i < points.rows; ++i) {
    const PointPair& pair = pairs[static_cast<std::size_t>(i)];
    const Vector2d& p = to ? pair.to : pair.from;
    points.at<cv::Vec2d>(i) = {p.x(), p.y()};
  }
  return points;
}

double Difference(const Matrix3d& H, const cv::Mat& other) {
  double worst = 0;
  for (const Vector2d& p : {Vector2d(0, 0), Vector2d(640, 0), Vector2d(640, 480), Vector2d(0, 480)}) {
    Matrix3d O = Matrix3d::Identity();
    for (int r = 0; r < other.rows; ++r)
      for (int c = 0; c < 3; ++c) O(r, c) = other.at<double>(r, c);
    worst =
        std::max(worst, ((H * p.homogeneous()).hnormalized() - (O * p.homogeneous()).hnormalized()).norm());
  }
  return worst;
}

TEST(MotionModel, NamesAreReadAsTheyAreWritten) {
  ASSERT_EQ(MotionModelNames().size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const auto model = static_cast<MotionModel>(i);
    EXPECT_EQ(MotionModelNamed(NameOf(model)), model);
  }
  EXPECT_FALSE(MotionModelNamed("rigid"));
}

TEST(MotionModel, EachFindsAMotionOfItsOwnExactly) {
  for (int i = 0; i < 4; ++i) {
    const auto model = static_cast<MotionModel>(i);
    const Matrix3d H = Motions()[static_cast<std::size_t>(i)];
    for (const int count : {MinPairs(model), 40}) {
      const auto fit = FitMotion(Pairs(H, 0, count), model);
      ASSERT_TRUE(fit) << NameOf(model) << " of " << count;
      EXPECT_LT((*fit - H).cwiseAbs().maxCoeff(), 1e-7) << NameOf(model) << " of " << count;
    }
    EXPECT_FALSE(FitMotion(Pairs(H, 0, MinPairs(model) - 1), model));
  }
}

TEST(MotionModel, OfNoisyPairsEachIsWhatOpenCvFinds) {
  constexpr double kAll_px = 1000;  // every pair is an inlier
  const auto& H = Motions();
  std::vector<PointPair> pairs = Pairs(H[1], 0.5);
  EXPECT_LT(Difference(*FitMotion(pairs, MotionModel::kSimilarity),
                       cv::estimateAffinePartial2D(Points(pairs, false), Points(pairs, true), cv::noArray(),
                                                   cv::RANSAC, kAll_px, 2000, 0.99, 100)),
            1e-3);
  pairs = Pairs(H[2], 0.5);
  EXPECT_LT(Difference(*FitMotion(pairs, MotionModel::kAffine),
                       cv::estimateAffine2D(Points(pairs, false), Points(pairs, true), cv::noArray(),
                                            cv::RANSAC, kAll_px, 2000, 0.99, 100)),
            1e-3);
  // OpenCV makes the distances least, which the algebraic error is near to.
  pairs = Pairs(H[3], 0.1);
  EXPECT_LT(Difference(*FitMotion(pairs, MotionModel::kHomography),
                       cv::findHomography(Points(pairs, false), Points(pairs, true), 0)),
            0.1);
}

TEST(MotionModel, NoEuclideanMotionNearbyFitsBetter) {
  const std::vector<PointPair> pairs = Pairs(Motions()[0], 0.5);
  const Matrix3d H = *FitMotion(pairs, MotionModel::kEuclidean);
  EXPECT_NEAR(H.topLeftCorner(2, 2).determinant(), 1, 1e-12);
  const double best = SquaredDistance(pairs, H);
  for (const double sign : {-1.0, 1.0}) {
    const double turn = 1e-4 * sign;
    Matrix3d turned = Matrix3d::Identity();
    turned.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    Vector2d mean = Vector2d::Zero();  // about which the points are turned
    for (const PointPair& pair : pairs) mean += pair.to / static_cast<double>(pairs.size());
    turned.topRightCorner<2, 1>() = mean - turned.topLeftCorner<2, 2>() * mean;
    EXPECT_GT(SquaredDistance(pairs, turned * H), best);
    for (int axis = 0; axis < 2; ++axis) {
      Matrix3d shifted = H;
      shifted(axis, 2) += 0.01 * sign;
      EXPECT_GT(SquaredDistance(pairs, shifted), best);
    }
  }
}

TEST(MotionModel, PairsThatAgreeOnNothingAreLeftOut) {
  for (int i = 0; i < 4; ++i) {
    const auto model = static_cast<MotionModel>(i);
    const Matrix3d H = Motions()[static_cast<std::size_t>(i)];
    std::vector<PointPair> pairs = Pairs(H, 0, 60);
    for (std::size_t k = 0; k < 60; k += 3) pairs[k].to += Vector2d(30 + static_cast<double>(k), -50);
    const auto fit = FitRobustMotion(pairs, model, {});
    ASSERT_TRUE(fit) << NameOf(model);
    EXPECT_EQ(fit->inliers.size(), 40u) << NameOf(model);
    EXPECT_LT((fit->H - H).cwiseAbs().maxCoeff(), 1e-7) << NameOf(model);
    EXPECT_LT(fit->rms_px, 1e-7);
  }
  EXPECT_FALSE(FitRobustMotion(Pairs(Motions()[0], 0, 11), MotionModel::kEuclidean, {}));
}

TEST(MotionModel, PairsAtOnePlaceFixNothing) {
  const std::vector<PointPair> pairs(20, PointPair{{3, 4}, {5, 6}});
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(FitMotion(pairs, static_cast<MotionModel>(i))) << i;
}

}  // namespace
}  // namespace kestrel::vision
