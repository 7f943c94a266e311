// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/circle_finder.h"

#include <gmock/gmock.h>

#include "base/diagnostics.h"
#include "tests/vision/calibration/board/board_set.h"
#include "vision/camera/brown_conrady.h"
#include "vision/camera/kannala_brandt.h"

namespace kestrel::vision {
namespace {

using ::testing::HasSubstr;

BrownConrady NarrowLens() {
  BrownConrady c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 560, c.cx = 322, c.cy = 236, c.k1 = -0.2;
  return c;
}

TEST(FindCircleGrid, CalibratesALensByTheMiddlesOfDiscsNotOfTheirImages) {
  const CircleGrid board{4, 11, 0.03, 0.025, true};
  const CameraModel camera = NarrowLens();
  const BoardSet set = PhotographSet(camera, board, 12, 91);
  EXPECT_GT(CornerError(camera, board, set, set.views), 0.04);  // the middles of the images
  const CameraModel like = CameraLike("pinhole", {640, 480});
  const std::vector<BoardView> refitted =
      Refit(board, set.images, set.views, Calibrate(board, set.views, like));
  EXPECT_LT(CornerError(camera, board, set, refitted), 0.025);
  const Calibration c = Calibrate(board, refitted, like);
  EXPECT_GE(c.corners, 300);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(std::abs(Parameters(c.camera)[i] - Parameters(camera)[i]), 4 * c.sigma[i]) << i;
    EXPECT_LT(c.sigma[i], 0.3) << i;
  }
}

TEST(FindCircleGrid, FindsSymmetricGridsThroughAFisheye) {
  const CircleGrid board{7, 6, 0.03, 0.018, false};
  KannalaBrandt fisheye;
  fisheye.width_px = 640, fisheye.height_px = 480;
  fisheye.fx = fisheye.fy = 215, fisheye.cx = 316, fisheye.cy = 243, fisheye.k1 = 0.02;
  const CameraModel camera = fisheye;
  const BoardSet set = PhotographSet(camera, board, 14, 92);
  const Calibration c = CalibrateSet(board, set, CameraLike("fisheye", {640, 480}));
  EXPECT_GE(c.corners, 4 * 40);
  for (int i = 0; i < 4; ++i)
    EXPECT_LT(std::abs(Parameters(c.camera)[i] - Parameters(camera)[i]), 4 * c.sigma[i]) << i;
  EXPECT_LT(c.rms_px, 0.05);
}

TEST(FindCircleGrid, DiscsOfAnotherSizeThanTheFileSaysAreRefused) {
  const CircleGrid board{4, 11, 0.03, 0.025, true};
  const BoardSet set = PhotographSet(NarrowLens(), board, 8, 93);
  const CameraModel like = CameraLike("pinhole", {640, 480});
  const auto refusal = [&](double spacing_m, double diameter_m) -> std::string {
    const CircleGrid wrong{4, 11, spacing_m, diameter_m, true};
    try {
      CalibrateSet(wrong, set, like);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal(0.03, 0.015),
              HasSubstr("circles of 15 mm with a spacing of 30 mm; by the images they are of 2"));
  EXPECT_THAT(refusal(0.06, 0.025), HasSubstr("one of the numbers is wrong"));
  EXPECT_EQ(refusal(0.03, 0.0245), "accepted");
}

TEST(FindCircleGrid, FindsNothingWhereThereIsNone) {
  cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(200));
  EXPECT_TRUE(FindBoard(grey, CircleGrid{}).empty());
  cv::circle(grey, {300, 200}, 20, cv::Scalar(20), cv::FILLED);
  EXPECT_TRUE(FindBoard(grey, CircleGrid{}).empty());
}

}  // namespace
}  // namespace kestrel::vision
