// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_reference.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kLength_m = 1.2, kWidth_m = 0.8;

// A white card 0.2 m long and 0.1 m wide on a black pad, its top left corner 0.3 m ahead and 0.1 m right of
// the centre; 500 px for each metre.
cv::Mat RenderedFrame() {
  cv::Mat picture(600, 400, CV_8UC1, cv::Scalar(20));
  picture(cv::Rect(250, 150, 50, 100)).setTo(230);
  return picture;
}

TEST(PadReference, EveryLevelMapsTheRimAndTheCentreOfThePadToThoseOfItsPicture) {
  for (const cv::Size size : {cv::Size(400, 600), cv::Size(455, 595), cv::Size(1001, 1333)}) {
    const PadReference reference =
        MakePadReference(cv::Mat(size, CV_8UC1, cv::Scalar(9)), kLength_m, kWidth_m);
    ASSERT_GE(reference.levels.size(), 4u);
    for (const PadReference::Level& level : reference.levels) {
      // the rim is half a pixel outside the centres of the outermost pixels
      const double right = level.image.cols - 0.5, bottom = level.image.rows - 0.5;
      const std::vector<Vector2d> rim = {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
      for (int k = 0; k < 4; ++k) {
        EXPECT_LT((Transfer(level.pixel_from_T, reference.Outline()[k]) - rim[k]).norm(), 1e-9);
      }
      EXPECT_LT((Transfer(level.pixel_from_T, {0, 0}) - Vector2d(right - 0.5, bottom - 0.5) / 2).norm(),
                1e-9);
    }
  }
}

TEST(PadReference, LevelsAreHalfAnOctaveApart) {
  const PadReference reference = MakePadReference(RenderedFrame(), kLength_m, kWidth_m);
  EXPECT_EQ(reference.levels.front().image.size(), cv::Size(400, 600));
  EXPECT_NEAR(reference.levels.front().px_per_m, 500, 1e-9);
  for (std::size_t i = 1; i < reference.levels.size(); ++i) {
    EXPECT_NEAR(reference.levels[i - 1].px_per_m / reference.levels[i].px_per_m, std::sqrt(2), 0.05);
    EXPECT_NEAR(cv::mean(reference.levels[i].image)[0], cv::mean(RenderedFrame())[0], 1);
  }
}

TEST(PadReference, OutlineGoesClockwiseFromThePicturesTopLeft) {
  const auto outline = MakePadReference(RenderedFrame(), kLength_m, kWidth_m).Outline();
  ASSERT_EQ(outline.size(), 4u);
  EXPECT_LT((outline[0] - Vector2d(0.6, -0.4)).norm(), 1e-12);
  for (int k = 0; k < 4; ++k) {  // z points down, so a positive turn about it is clockwise seen from above
    const Vector2d side = outline[(k + 1) % 4] - outline[k],
                   next = outline[(k + 2) % 4] - outline[(k + 1) % 4];
    EXPECT_GT(side.x() * next.y() - side.y() * next.x(), 0);
  }
  EXPECT_NEAR((outline[1] - outline[0]).norm(), kWidth_m, 1e-12);
  EXPECT_NEAR((outline[2] - outline[1]).norm(), kLength_m, 1e-12);
}

TEST(PadReference, FindsTheCornersOfACardWhereItLies) {
  const PadReference reference = MakePadReference(RenderedFrame(), kLength_m, kWidth_m);
  const PadReference::Level& fine = reference.levels.front();
  ASSERT_EQ(fine.corners.size(), 4u);
  for (const Vector2d& corner :
       {Vector2d(0.3, 0.1), Vector2d(0.3, 0.2), Vector2d(0.1, 0.2), Vector2d(0.1, 0.1)}) {
    double nearest = 1;
    for (const Vector2d& found : fine.corners) nearest = std::min(nearest, (found - corner).norm());
    EXPECT_LT(nearest, 3 / fine.px_per_m);  // the strongest window lies inside the corner
  }
}

TEST(PadReference, CornersKeepOffTheRim) {
  std::mt19937 rng(7);
  cv::Mat picture(600, 400, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) picture.at<uchar>(y, x) = static_cast<uchar>(rng() >> 24);
  }
  const PadReference reference = MakePadReference(picture, kLength_m, kWidth_m);
  for (const PadReference::Level& level : reference.levels) {
    EXPECT_GE(level.corners.size(), 4u);
    for (const Vector2d& corner : level.corners) {
      EXPECT_LT(std::abs(corner.x()), kLength_m / 2 - 2 / level.px_per_m);
      EXPECT_LT(std::abs(corner.y()), kWidth_m / 2 - 2 / level.px_per_m);
    }
  }
}

TEST(PadReference, TakesAColourPictureForItsGrey) {
  cv::Mat colour;
  cv::cvtColor(RenderedFrame(), colour, cv::COLOR_GRAY2BGR);
  const PadReference reference = MakePadReference(colour, kLength_m, kWidth_m);
  EXPECT_EQ(reference.levels.front().image.type(), CV_8UC1);
  EXPECT_EQ(cv::norm(reference.levels.front().image, RenderedFrame(), cv::NORM_INF), 0);
}

TEST(PadReference, ChoosesTheCoarsestLevelThatStillShowsWhatTheCameraSees) {
  const PadReference reference = MakePadReference(RenderedFrame(), kLength_m, kWidth_m);
  EXPECT_EQ(&reference.LevelFor(2000), &reference.levels.front());
  EXPECT_EQ(&reference.LevelFor(500), &reference.levels.front());
  EXPECT_EQ(&reference.LevelFor(250), &reference.levels[2]);
  EXPECT_EQ(&reference.LevelFor(200), &reference.levels[2]);
  EXPECT_GE(&reference.LevelFor(1e-3), &reference.levels.back() - 1);
}

TEST(PadReference, TheNearestLevelIsWithinAQuarterOfAnOctave) {
  const PadReference reference = MakePadReference(RenderedFrame(), kLength_m, kWidth_m);
  for (double px_per_m = 500; px_per_m > reference.levels.back().px_per_m; px_per_m *= 0.9)
    EXPECT_LT(std::abs(std::log2(reference.NearestLevel(px_per_m).px_per_m / px_per_m)), 0.27) << px_per_m;
  EXPECT_EQ(&reference.NearestLevel(2000), &reference.levels.front());
  EXPECT_EQ(&reference.NearestLevel(1e-3), &reference.levels.back());
}

}  // namespace
}  // namespace kestrel::vision
