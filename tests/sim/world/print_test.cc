// SPDX-License-Identifier: Apache-2.0
#include "sim/world/print.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::sim {
namespace {

// 400 x 200 pixels on 0.2 m x 0.1 m: 2 px/mm. Black left of the middle, white right of it.
cv::Mat HalfWhite() {
  cv::Mat picture(200, 400, CV_8UC1, cv::Scalar(0));
  picture.colRange(200, 400).setTo(255);
  return picture;
}
const Eigen::Vector2d kSize_m(0.1, 0.2);

TEST(Print, OfNothingSaidIsThePicture) {
  EXPECT_EQ(cv::norm(Printed(HalfWhite(), kSize_m, {}, 1), HalfWhite(), cv::NORM_INF), 0);
}

TEST(Print, HasItsOwnBlackAndWhite) {
  const cv::Mat printed = Printed(HalfWhite(), kSize_m, {.black = 30, .white = 200}, 1);
  EXPECT_EQ(printed.at<uchar>(100, 10), 30);
  EXPECT_EQ(printed.at<uchar>(100, 390), 200);
}

// The edge of a step spread by a Gaussian is the normal distribution.
TEST(Print, InkSpreadsByItsMillimetres) {
  constexpr double kSpread_mm = 4;
  const cv::Mat printed = Printed(HalfWhite(), kSize_m, {.spread_mm = kSpread_mm}, 1);
  for (const int u : {184, 192, 200, 208}) {
    const double at_mm = (u + 0.5 - 200) / 2;
    EXPECT_NEAR(printed.at<uchar>(100, u), 255 * 0.5 * std::erfc(-at_mm / kSpread_mm / std::sqrt(2)), 2) << u;
  }
}

TEST(Print, GrainHasItsDeviationAndSizeAndSeed) {
  const cv::Mat grey(200, 400, CV_8UC1, cv::Scalar(128));
  const PrintParameters print{.grain_grey = 10, .grain_mm = 2};  // 4 px
  const cv::Mat printed = Printed(grey, kSize_m, print, 1);
  cv::Scalar mean, sigma;
  cv::meanStdDev(printed, mean, sigma);
  EXPECT_NEAR(mean[0], 128, 0.6);
  EXPECT_NEAR(sigma[0], 10, 0.6);
  EXPECT_EQ(cv::norm(printed(cv::Rect(0, 0, 4, 4)),
                     cv::Mat(4, 4, CV_8UC1, cv::Scalar(printed.at<uchar>(0, 0))), cv::NORM_INF),
            0);
  EXPECT_EQ(cv::norm(printed, Printed(grey, kSize_m, print, 1), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(printed, Printed(grey, kSize_m, print, 2), cv::NORM_INF), 0);
}

TEST(Print, AShareOfItLiesInTheShadeToOneSide) {
  const cv::Mat grey(200, 400, CV_8UC1, cv::Scalar(200));
  for (const std::uint64_t seed : {1, 2, 3}) {
    const cv::Mat printed = Printed(grey, kSize_m, {.shade = 0.3, .shade_light = 0.4}, seed);
    const double dark = cv::countNonZero(printed < 140) / static_cast<double>(printed.total());
    EXPECT_NEAR(dark, 0.3, 0.01) << seed;
    double low = 0, high = 0;
    cv::minMaxLoc(printed, &low, &high);
    EXPECT_EQ(low, 80);
    EXPECT_EQ(high, 200);
    const cv::Moments of_shade =
        cv::moments(printed < 140, true);  // to one side: its middle is not that of the picture
    EXPECT_GT(std::hypot(of_shade.m10 / of_shade.m00 - 200, of_shade.m01 / of_shade.m00 - 100), 30) << seed;
  }
  EXPECT_EQ(cv::countNonZero(Printed(grey, kSize_m, {.shade = 1, .shade_light = 0.4}, 1) != 80), 0);
}

TEST(Print, WhereItIsWetWhiteIsDarkerAndBlackIsNot) {
  const cv::Mat white(400, 400, CV_8UC1, cv::Scalar(255)), black(400, 400, CV_8UC1, cv::Scalar(0));
  const Eigen::Vector2d size_m(1, 1);
  const cv::Mat of_white = Printed(white, size_m, {.wet = 0.2}, 4),
                of_black = Printed(black, size_m, {.wet = 0.2}, 4);
  EXPECT_NEAR(cv::countNonZero(of_white < 200) / 160000.0, 0.2, 0.02);
  EXPECT_NEAR(cv::countNonZero(of_black > 7) / 160000.0, 0.2, 0.02);
  EXPECT_GT(cv::countNonZero(of_white == 255), 100000);
}

}  // namespace
}  // namespace kestrel::sim
