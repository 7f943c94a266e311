// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/baseline/skyline_baseline.h"

#include <gtest/gtest.h>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"
#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::vision {
namespace {

TEST(SkylineBaseline, SkyWeightIsTheFormula) {
  cv::Mat image(1, 4, CV_8UC3);
  image.at<cv::Vec3b>(0, 0) = {100, 50, 50};   // 3 * 10000 / 200 = 150
  image.at<cv::Vec3b>(0, 1) = {0, 0, 0};       // nothing
  image.at<cv::Vec3b>(0, 2) = {255, 10, 10};   // clipped
  image.at<cv::Vec3b>(0, 3) = {40, 100, 100};  // 3 * 1600 / 240 = 20
  const cv::Mat weight = SkyWeight(image);
  EXPECT_EQ(weight.at<uchar>(0, 0), 150);
  EXPECT_EQ(weight.at<uchar>(0, 1), 0);
  EXPECT_EQ(weight.at<uchar>(0, 2), 255);
  EXPECT_EQ(weight.at<uchar>(0, 3), 20);
}

TEST(SkylineBaseline, FindsAFreeHorizonInABlueSkyToADegree) {
  Mistakes mistakes;
  const CameraModel camera =
      LoadCamera(std::string(KESTREL_SOURCE_DIR) + "/models/cameras/hyperbolic_mirror.yaml", mistakes);
  PaintedWorld world;
  world.horizon = {235, 200, 170};
  const TaitBryan attitude{0.5, Radians(6), Radians(-8)};
  const cv::Mat image =
      SkylinePhotographer(camera).Paint(world, RotationFromTaitBryan(attitude) * LooksDown(), 1);
  const auto found = SkylineBaseline(camera, LooksDown()).Measure(image);
  ASSERT_TRUE(found);
  EXPECT_NEAR(Degrees(found->roll), -8, 1.5);
  EXPECT_NEAR(Degrees(found->pitch), 6, 1.5);
}

TEST(CompassBaseline, TheDistanceIsLeastAtTheShiftAndNoneThere) {
  cv::Mat wide(20, 120, CV_8UC1);
  cv::RNG rng(3);
  rng.fill(wide, cv::RNG::UNIFORM, 0, 255);
  const cv::Mat a = wide.colRange(0, 100), b = wide.colRange(7, 107);  // b(i) is a(i + 7)
  EXPECT_EQ(CompassBaseline::Distance(a, b, -7), 0);
  for (int k = -20; k <= 20; ++k) {
    if (k == -7) continue;
    EXPECT_GT(CompassBaseline::Distance(a, b, k), 50) << k;
  }
}

}  // namespace
}  // namespace kestrel::vision
