// SPDX-License-Identifier: Apache-2.0
#include "vision/target/colour_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/vision/target/balloon_photographer.h"

namespace kestrel::vision {
namespace {

// The definition of hue, saturation and value, the other way round; 0 to 255.
cv::Vec3b Bgr(double hue_deg, double saturation, double value) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue_deg / 60 + 6, 6);
    return cv::saturate_cast<uchar>(255 * value *
                                    (1 - saturation * std::max(0.0, std::min({k, 4 - k, 1.0}))));
  };
  return {channel(1), channel(3), channel(5)};
}

int WeightOf(const ColourModel& model, const cv::Vec3b& bgr) {
  cv::Mat weights;
  model.BackProject(cv::Mat(2, 2, CV_8UC3, cv::Scalar(bgr[0], bgr[1], bgr[2])), weights);
  return weights.at<uchar>(1, 1);
}

TEST(ColourModelTest, ARangeMatchesItsHuesAcrossTheSeamOfTheCircleAndNothingGreyOrDark) {
  const ColourModel red({.hue_deg = 0, .hue_half_width_deg = 15});
  for (const double hue : {-10.0, -3.0, 0.0, 3.0, 10.0})
    EXPECT_EQ(WeightOf(red, Bgr(hue, 0.8, 0.7)), 255) << hue;
  for (const double hue : {-25.0, 25.0, 60.0, 120.0, 180.0, 240.0})
    EXPECT_EQ(WeightOf(red, Bgr(hue, 0.8, 0.7)), 0) << hue;
  EXPECT_EQ(WeightOf(red, Bgr(0, 0.3, 0.7)), 0);
  EXPECT_EQ(WeightOf(red, Bgr(0, 0.9, 0.06)), 0);
  EXPECT_EQ(WeightOf(ColourModel({.hue_deg = 120}), Bgr(120, 0.8, 0.7)), 255);
}

TEST(ColourModelTest, LearntFromAPatchItMatchesTheWholeBallAndNotTheBackground) {
  const Pinhole camera{320, 240, 250, 250, 159.5, 119.5};
  PaintedBalls world;
  world.balls[0].p_CT = {0.3, 0.2, 2};
  const cv::Mat image = PaintBalls(camera, world);
  const Eigen::Vector2d centre = *camera.Project(world.balls[0].p_CT);
  const cv::Point middle(static_cast<int>(centre.x()), static_cast<int>(centre.y()));
  cv::Mat patch = cv::Mat::zeros(image.size(), CV_8UC1);
  cv::circle(patch, middle, 20, 255, cv::FILLED);
  // Of the surroundings only what is surely not the ball.
  const TrainedColour lesson = ColourModel::Train(image(cv::Rect(middle.x - 60, middle.y - 60, 120, 120)),
                                                  patch(cv::Rect(middle.x - 60, middle.y - 60, 120, 120)));
  ASSERT_EQ(lesson.state, TrainingState::kTrained);
  cv::Mat weights;
  lesson.model.BackProject(image, weights);
  int on = 0, ball = 0, off = 0, rest = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const double away = (camera.Ray({x, y})->cross(world.balls[0].p_CT)).norm() / world.balls[0].radius;
      const bool matches = weights.at<uchar>(y, x) > 127;
      if (away < 0.95) ++ball, on += matches;
      if (away > 1.05) ++rest, off += matches;
    }
  EXPECT_GT(on, 0.97 * ball);
  EXPECT_LT(off, 0.002 * rest);
  EXPECT_NEAR(ColourModel::Matched(weights), static_cast<double>(ball) / (320 * 240), 0.005);
}

TEST(ColourModelTest, WhatCannotBeLearntIsNamed) {
  cv::Mat image(60, 60, CV_8UC3, cv::Scalar(120, 120, 120)), patch = cv::Mat::zeros(60, 60, CV_8UC1);
  patch(cv::Rect(20, 20, 20, 20)) = 255;
  EXPECT_EQ(ColourModel::Train(image, patch).state, TrainingState::kTooGrey);
  EXPECT_EQ(ColourModel::Train(image, cv::Mat()).state, TrainingState::kBadPatch);
  EXPECT_EQ(ColourModel::Train(cv::Mat(60, 60, CV_8UC1), patch).state, TrainingState::kBadPatch);
  EXPECT_EQ(ColourModel::Train(image, cv::Mat::zeros(60, 60, CV_8UC1)).state, TrainingState::kTooFewPixels);
  for (int x = 20; x < 40; ++x) image(cv::Rect(x, 20, 1, 20)) = cv::Scalar(Bgr(18.0 * (x - 20), 0.9, 0.8));
  EXPECT_EQ(ColourModel::Train(image, patch).state, TrainingState::kTooManyColours);
  image = cv::Scalar(Bgr(10, 0.9, 0.8));
  EXPECT_EQ(ColourModel::Train(image, patch).state, TrainingState::kLikeSurroundings);
  image = cv::Scalar(Bgr(200, 0.9, 0.8));
  image(cv::Rect(20, 20, 20, 20)) = cv::Scalar(Bgr(10, 0.9, 0.8));
  EXPECT_EQ(ColourModel::Train(image, patch).state, TrainingState::kTrained);
}

}  // namespace
}  // namespace kestrel::vision
