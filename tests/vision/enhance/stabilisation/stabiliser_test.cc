// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/stabiliser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "geometry/pose.h"
#include "tests/vision/enhance/motion/random_scene.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kRate_hz = 30;
const cv::Size kSize(160, 120);

const cv::Mat& Scene() {
  static const cv::Mat scene = RandomScene({1200, 400}, 7);
  return scene;
}

// Of the scene, at a place from the middle of its left part.
cv::Mat ImageAt(const cv::Point& place) { return Scene()(cv::Rect(cv::Point(120, 140) + place, kSize)); }

StabiliserOptions Reference() {
  StabiliserOptions options;
  options.mode = "reference", options.crop = 1, options.scale = false;
  return options;
}

std::vector<StabilisedImage> All(const StabiliserOptions& options, const std::vector<cv::Mat>& images) {
  Stabiliser stabiliser(options, {}, kRate_hz);
  std::vector<StabilisedImage> all;
  for (std::size_t i = 0; i < images.size(); ++i)
    if (auto image = stabiliser.Step(images[i], static_cast<double>(i) / kRate_hz)) all.push_back(*image);
  while (auto image = stabiliser.Finish()) all.push_back(*image);
  return all;
}

// The farthest that four points of the reference are seen from their places, of each hundred images.
std::vector<double> Wandering_px(double amplitude_px, int hundreds) {
  Stabiliser stabiliser(Reference(), {}, kRate_hz);
  std::vector<double> worst_px(static_cast<std::size_t>(hundreds), 0.0);
  for (int i = 0; i < 100 * hundreds; ++i) {
    const cv::Point place(static_cast<int>(std::lround(amplitude_px * std::sin(0.31 * i))),
                          static_cast<int>(std::lround(0.7 * amplitude_px * std::sin(0.47 * i))));
    const auto image = stabiliser.Step(ImageAt(place), i / kRate_hz);
    EXPECT_EQ(image->state, i == 0 ? StabilisedState::kFirst : StabilisedState::kFollowed) << i;
    double& worst = worst_px[static_cast<std::size_t>(i / 100)];
    for (const Vector2d& corner :
         {Vector2d(20, 20), Vector2d(140, 20), Vector2d(140, 100), Vector2d(20, 100)}) {
      const auto shown = ShownAt(image->view, nullptr, corner - Vector2d(place.x, place.y));
      worst = std::max(worst, (*shown - corner).norm());
    }
  }
  return worst_px;
}

TEST(Stabiliser, ToAReferenceDoesNotDriftInHundredsOfImages) {
  const std::vector<double> worst_px = Wandering_px(8, 4);
  ASSERT_EQ(worst_px.size(), 4u);
  for (const double worst : worst_px) EXPECT_LT(worst, 0.25) << ::testing::PrintToString(worst_px);
  EXPECT_LT(worst_px.back(), worst_px.front() + 0.05);
}

// A quarter of the image is lost now and then, and keyframes follow one another.
TEST(Stabiliser, KeyframesThatFollowOneAnotherAddLittle) {
  const std::vector<double> worst_px = Wandering_px(20, 4);
  ASSERT_EQ(worst_px.size(), 4u);
  for (const double worst : worst_px) EXPECT_LT(worst, 0.6) << ::testing::PrintToString(worst_px);
}

// The view goes far away, by keyframes that follow one another, and comes back: there the reference itself is compared
// with, and the error is that of one comparison, however often it went.
TEST(Stabiliser, AViewThatComesBackIsComparedWithTheReferenceAgain) {
  Stabiliser stabiliser(Reference(), {}, kRate_hz);
  constexpr int kPeriod = 60, kPeriods = 6;
  int back = 0;
  for (int i = 0; i < kPeriod * kPeriods; ++i) {
    const double phase = 2 * std::numbers::pi * i / kPeriod;
    const cv::Point place(static_cast<int>(std::lround(70 * std::sin(phase))),
                          static_cast<int>(std::lround(25 * (1 - std::cos(phase)))));
    const auto image = stabiliser.Step(ImageAt(place), i / kRate_hz);
    ASSERT_NE(image->state, StabilisedState::kReanchored) << i;
    if (i % kPeriod != 0) continue;
    ++back;
    for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(159, 119)})
      EXPECT_LT((*ShownAt(image->view, nullptr, corner) - corner).norm(), 0.1) << i;
  }
  EXPECT_EQ(back, kPeriods);
}

TEST(Stabiliser, AJumpOf300PixelsIsRecoveredInTheSameImage) {
  const cv::Mat scene = RandomScene({1000, 480}, 2);
  StabiliserOptions options = Reference();
  const auto all = All(options, {scene(cv::Rect(0, 0, 640, 480)), scene(cv::Rect(300, 0, 640, 480)),
                                 scene(cv::Rect(300, 0, 640, 480))});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[1].state, StabilisedState::kRecovered);
  for (const std::size_t i : {1u, 2u})
    EXPECT_LT((*ShownAt(all[i].view, nullptr, Vector2d(100, 200)) - Vector2d(400, 200)).norm(), 0.5) << i;
}

TEST(Stabiliser, AVideoThatBeginsInTheDarkIsFollowedFromItsFirstTexture) {
  const cv::Mat dark(kSize, CV_8UC1, cv::Scalar(3));
  int modes = 0;
  for (const char* mode : {"reference", "smooth"}) {
    StabiliserOptions options = Reference();
    options.mode = mode;
    const auto all = All(options, {dark, dark, ImageAt({0, 0}), ImageAt({4, 0}), ImageAt({6, 2})});
    ASSERT_EQ(all.size(), 5u);
    EXPECT_EQ(all[1].state, StabilisedState::kTextureless);
    EXPECT_EQ(all[2].state, StabilisedState::kTextureless);
    EXPECT_EQ(all[3].state, StabilisedState::kFollowed);
    EXPECT_EQ(all[4].state, StabilisedState::kFollowed);
    ++modes;
  }
  EXPECT_EQ(modes, 2);
}

TEST(Stabiliser, AReferenceOutOfTheViewIsReplaced) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < 40; ++i) images.push_back(ImageAt({5 * i, 0}));
  int anchors = 0;
  for (const StabilisedImage& image : All(Reference(), images)) {
    if (image.state != StabilisedState::kReanchored) continue;
    ++anchors;
    EXPECT_LT((*ShownAt(image.view, nullptr, Vector2d(50, 50)) - Vector2d(50, 50)).norm(), 1e-6);
  }
  EXPECT_EQ(anchors, 1);  // after 70 % of 160 pixels
}

TEST(Stabiliser, ASmoothPathKeepsTheWayAndLosesTheShakes) {
  StabiliserOptions options;
  options.lag_s = 1, options.crop = 1, options.scale = false, options.bound = false;
  std::vector<cv::Mat> images;
  std::vector<double> shakes;
  constexpr int kImages = 90;
  for (int i = 0; i < kImages; ++i) {
    shakes.push_back(std::lround(8 * std::sin(2 * std::numbers::pi * 3 * i / kRate_hz)));
    images.push_back(ImageAt({2 * i + static_cast<int>(shakes.back()), 0}));
  }
  const auto all = All(options, images);
  ASSERT_EQ(all.size(), images.size());
  std::vector<double> errors;
  for (int i = 30; i < 60; ++i) {  // whole periods, with images on both sides
    const auto at = static_cast<std::size_t>(i);
    ASSERT_EQ(all[at].number, i);
    // The path goes on by 2 pixels an image; a point at 80 of it is seen where the shake has it.
    errors.push_back(ShownAt(all[at].view, nullptr, Vector2d(80 - shakes[at], 60))->x() - 80);
  }
  double mean = 0, square = 0;
  for (const double error : errors) mean += error / 30;
  for (const double error : errors) square += (error - mean) * (error - mean) / 30;
  EXPECT_LT(std::abs(mean), 1);
  EXPECT_LT(std::sqrt(square), 0.05 * 8 / std::numbers::sqrt2);
}

TEST(Stabiliser, ABoundViewStaysWithinTheImage) {
  StabiliserOptions options;
  options.lag_s = 0.5, options.crop = 0.9;
  std::vector<cv::Mat> images;
  for (int i = 0; i < 60; ++i)
    images.push_back(
        ImageAt({static_cast<int>(std::lround(25 * std::sin(2 * std::numbers::pi * 2 * i / kRate_hz))), 0}));
  const auto outside = [&] {
    int count = 0;
    for (const StabilisedImage& image : All(options, images)) {
      for (const double x : {0.0, image.view.size.width - 1.0}) {
        const Vector2d from = *SourceOf(image.view, nullptr, Vector2d(x, 60));
        count += from.x() < -0.1 || from.x() > kSize.width - 0.9;
      }
    }
    return count;
  };
  EXPECT_EQ(outside(), 0);
  options.bound = false;
  EXPECT_GT(outside(), 10);
}

TEST(Stabiliser, TheCropIsTheMiddleOfTheImage) {
  StabiliserOptions options = Reference();
  options.crop = 0.8;
  const cv::Mat image = ImageAt({0, 0});
  const auto all = All(options, {image});
  ASSERT_EQ(all.size(), 1u);
  ASSERT_EQ(all[0].image.size(), cv::Size(128, 96));
  EXPECT_EQ(cv::norm(all[0].image, image(cv::Rect(16, 12, 128, 96)), cv::NORM_INF), 0);
  options.scale = true;
  EXPECT_EQ(All(options, {image})[0].image.size(), kSize);
}

TEST(Stabiliser, BordersAreBlackOrBlurredOrOfEarlierImages) {
  constexpr int kShift = 20;
  const std::vector<cv::Mat> images = {ImageAt({0, 0}), ImageAt({kShift, 0})};
  const cv::Rect rim(0, 10, kShift - 2, 100);
  StabiliserOptions options = Reference();
  const cv::Mat black = All(options, images)[1].image(rim);
  EXPECT_EQ(cv::countNonZero(black), 0);
  options.border = "blurred";
  cv::Scalar mean, deviation;
  cv::meanStdDev(All(options, images)[1].image(rim), mean, deviation);
  EXPECT_GT(mean[0], 60);
  EXPECT_LT(deviation[0], 40);
  options.border = "filled";
  EXPECT_LT(cv::norm(All(options, images)[1].image(rim), images[0](rim), cv::NORM_L1) / rim.area(), 8);
}

TEST(Stabiliser, EveryStateIsNamed) {
  const cv::Mat a = ImageAt({0, 0}), other = RandomScene(kSize, 99), flat(kSize, CV_8UC1, cv::Scalar(90)),
                small = RandomScene({80, 60}, 5);
  const auto all = All(Reference(), {a, a, flat, a, other, small});
  ASSERT_EQ(all.size(), 6u);
  using S = StabilisedState;
  const S states[] = {S::kFirst, S::kFollowed, S::kTextureless, S::kFollowed, S::kCut, S::kResized};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(all[i].state, states[i]) << i << ": " << NameOf(all[i].state);
  // A new beginning is its own reference.
  EXPECT_EQ(cv::norm(all[4].image, other, cv::NORM_INF), 0);
  EXPECT_EQ(all[5].image.size(), small.size());
}

TEST(Stabiliser, OneImageIsShownAsItIs) {
  for (const char* mode : {"reference", "smooth", "offline"}) {
    StabiliserOptions options = Reference();
    options.mode = mode;
    const auto all = All(options, {ImageAt({0, 0})});
    ASSERT_EQ(all.size(), 1u) << mode;
    EXPECT_LE(cv::norm(all[0].image, ImageAt({0, 0}), cv::NORM_INF), 1) << mode;
  }
}

TEST(Stabiliser, AGyroAloneUndoesATurnAndTellsWhereItHasNothing) {
  const Pinhole pinhole{.width_px = 160, .height_px = 120, .fx = 150, .fy = 150, .cx = 79.5, .cy = 59.5};
  const CameraModel camera = pinhole;
  StabiliserOptions options = Reference();
  options.by = "gyro";
  Stabiliser stabiliser(options, camera, kRate_hz);
  const Eigen::Quaterniond turn = ExpRotation({0.02, 0.05, -0.1});
  EXPECT_EQ(stabiliser.Step(ImageAt({0, 0}), 0, {{Eigen::Quaterniond::Identity()}, {}, 0})->state,
            StabilisedState::kFirst);
  const auto image = stabiliser.Step(ImageAt({0, 0}), 0.1, {{turn}, {}, 0});
  EXPECT_EQ(image->state, StabilisedState::kGyro);
  // What the camera sees along a ray of the first image is shown where that one had it.
  const Vector2d at(60, 50), seen = *pinhole.Project(turn.conjugate() * *pinhole.Ray(at));
  EXPECT_LT((*ShownAt(image->view, &camera, seen) - at).norm(), 1e-6);
  EXPECT_EQ(stabiliser.Step(ImageAt({0, 0}), 0.2)->state, StabilisedState::kNoAttitude);
  EXPECT_THROW(Stabiliser(options, {}, kRate_hz), std::invalid_argument);
}

}  // namespace
}  // namespace kestrel::vision
