// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/outline/outlines.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

// Drawn by its definition: dark where (M (p - middle)) is within the unit circle, averaged over 8 x 8 samples.
cv::Mat EllipseImage(const Eigen::Vector2d& middle, const Eigen::Matrix2d& axes) {
  constexpr int kFine = 8;
  const Eigen::Matrix2d to_circle = axes.inverse();
  cv::Mat image(200, 300, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      int inside = 0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const Eigen::Vector2d p(u + (i % kFine + 0.5) / kFine - 0.5, v + (i / kFine + 0.5) / kFine - 0.5);
        inside += (to_circle * (p - middle)).squaredNorm() < 1;
      }
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(200 - 150.0 * inside / (kFine * kFine));
    }
  }
  return image;
}

// Without the rim of the image, which is a rectangle too.
std::vector<Quad> QuadsWithin(const cv::Mat& image) {
  std::vector<Quad> quads = QuadsOf(LargeContours(image));
  std::erase_if(quads, [&](const Quad& quad) {
    return (quad[2] - quad[0]).norm() > 0.95 * std::hypot(image.cols, image.rows);
  });
  return quads;
}

TEST(Outlines, AnEllipseIsFoundToAFractionOfAPixel) {
  const Eigen::Vector2d middle(140.3, 95.8);
  for (const double turn : {0.0, 0.4, 1.3, 2.5}) {
    const Eigen::Matrix2d axes =
        Eigen::Rotation2Dd(turn).toRotationMatrix() * Eigen::Vector2d(70, 45).asDiagonal();
    const auto found = EllipsesOf(LargeContours(EllipseImage(middle, axes)));
    ASSERT_FALSE(found.empty()) << turn;
    EXPECT_LT((found[0].middle - middle).norm(), 0.3) << turn;
    EXPECT_GT(found[0].axes.determinant(), 0);
    // The shape, whichever axis comes first.
    EXPECT_LT((found[0].axes * found[0].axes.transpose() - axes * axes.transpose()).norm(), 0.03 * 70 * 70)
        << turn;
  }
}

TEST(Outlines, ARectangleIsNoEllipseAndAnEllipseNoRectangle) {
  cv::Mat image(200, 300, CV_8UC1, cv::Scalar(200));
  cv::rectangle(image, cv::Rect(60, 50, 150, 90), 50, cv::FILLED);
  EXPECT_TRUE(EllipsesOf(LargeContours(image)).empty());
  EXPECT_FALSE(QuadsWithin(image).empty());
  const cv::Mat round = EllipseImage({150, 100}, Eigen::Vector2d(80, 60).asDiagonal());
  EXPECT_TRUE(QuadsWithin(round).empty());
}

TEST(Outlines, CornersOfARectangleGoClockwise) {
  cv::Mat image(200, 300, CV_8UC1, cv::Scalar(200));
  cv::rectangle(image, cv::Rect(60, 50, 150, 90), 50, cv::FILLED);
  const auto quads = QuadsWithin(image);
  ASSERT_FALSE(quads.empty());
  double twice_area = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d &a = quads[0][k], &b = quads[0][(k + 1) % 4];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_NEAR(twice_area / 2, 149 * 89, 3 * (149 + 89));  // positive: clockwise with v downwards
}

}  // namespace
}  // namespace kestrel::vision
