// SPDX-License-Identifier: Apache-2.0
#include "vision/target/box_tracker.h"

#include <gtest/gtest.h>

#include "tests/vision/target/balloon_photographer.h"

namespace kestrel::vision {
namespace {

const Pinhole kCamera{160, 120, 125, 125, 79.5, 59.5};

TEST(BoxTrackerTest, OverlapIsSharedOverWholeArea) {
  EXPECT_DOUBLE_EQ(Overlap({0, 0, 2, 2}, {0, 0, 2, 2}), 1);
  EXPECT_DOUBLE_EQ(Overlap({0, 0, 2, 2}, {1, 0, 2, 2}), 2.0 / 6);
  EXPECT_DOUBLE_EQ(Overlap({0, 0, 2, 2}, {5, 0, 2, 2}), 0);
  EXPECT_DOUBLE_EQ(Overlap({}, {}), 0);
}

TEST(BoxTrackerTest, AllFollowAnUndisturbedBallAndTheOutlineBest) {
  const ColourModel red{ColourRange{}};
  std::vector<double> overlaps;
  for (const BoxTracker& tracker :
       {CamShiftBoxes(red), BalloonBoxes(red, kCamera), KcfBoxes(), CsrtBoxes()}) {
    double sum = 0;
    constexpr int kFrames = 6;
    for (int k = 0; k <= kFrames; ++k) {
      PaintedBalls world;
      world.balls[0].p_CT = {-0.3 + 0.05 * k, 0.1, 2};
      const cv::Mat image = PaintBalls(kCamera, world, k);
      const cv::Rect2d truth = *OutlineBox(kCamera, *ConeOfSphere(world.balls[0].p_CT, 0.25));
      if (k == 0) {
        ASSERT_TRUE(tracker.start(image, truth)) << tracker.name;
        continue;
      }
      const auto box = tracker.track(image);
      ASSERT_TRUE(box) << tracker.name << ' ' << k;
      sum += Overlap(*box, truth);
    }
    overlaps.push_back(sum / kFrames);
    EXPECT_GT(overlaps.back(), 0.6) << tracker.name;
  }
  EXPECT_GT(overlaps[1], 0.97);
  for (const std::size_t other : {0u, 2u, 3u}) EXPECT_GT(overlaps[1], overlaps[other]);
}

TEST(BoxTrackerTest, WithoutATargetTheyAreLostAndNothingThrows) {
  const ColourModel red{ColourRange{}};
  const cv::Mat empty = cv::Mat::zeros(120, 160, CV_8UC3);
  for (const BoxTracker& tracker :
       {CamShiftBoxes(red), BalloonBoxes(red, kCamera), KcfBoxes(), CsrtBoxes()}) {
    EXPECT_FALSE(tracker.track(empty)) << tracker.name << " before its start";
    EXPECT_FALSE(tracker.start(empty, {})) << tracker.name;
  }
}

}  // namespace
}  // namespace kestrel::vision
