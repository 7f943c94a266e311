// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::sim {
namespace {

// Wide, with its principal point off the middle.
const vision::Pinhole kCamera{160, 120, 70, 75, 85.25, 52.5};

TEST(Shade, OffThereIsNone) { EXPECT_TRUE(Shade({}, kCamera).empty()); }

TEST(Shade, FollowsTheNaturalLawOfTheRaysAngle) {
  LensParameters lens;
  lens.cos_power = 4;
  const cv::Mat shade = Shade(lens, kCamera);
  ASSERT_EQ(shade.size(), cv::Size(160, 120));
  for (int y = 0; y < shade.rows; ++y) {
    for (int x = 0; x < shade.cols; ++x) {
      // cos = 1 / sqrt(1 + tan^2)
      const double tan2 = std::pow((x - 85.25) / 70, 2) + std::pow((y - 52.5) / 75, 2);
      ASSERT_NEAR(shade.at<float>(y, x), 1 / ((1 + tan2) * (1 + tan2)), 1e-6) << x << ' ' << y;
    }
  }
}

TEST(Shade, FollowsTheRadialPolynomialAndStopsAtBlack) {
  LensParameters lens;
  lens.vignetting = {-0.5, 0.3, -1.1};
  const cv::Mat shade = Shade(lens, kCamera);
  int black = 0;
  for (int y = 0; y < shade.rows; ++y) {
    for (int x = 0; x < shade.cols; ++x) {
      const double r = std::hypot(x - 85.25, y - 52.5) / 100;  // half the diagonal of 160 x 120
      const double wanted = 1 - 0.5 * r * r + 0.3 * std::pow(r, 4) - 1.1 * std::pow(r, 6);
      ASSERT_NEAR(shade.at<float>(y, x), std::max(0.0, wanted), 1e-6) << x << ' ' << y;
      black += wanted <= 0;
    }
  }
  EXPECT_GT(black, 0);
}

TEST(Shade, TheRimIsADiscOfItsRadiusAboutThePrincipalPoint) {
  LensParameters lens;
  lens.rim_px = 40.3;
  const cv::Mat shade = Shade(lens, kCamera);
  // The edge is found to an eighth of a pixel, at random along it.
  EXPECT_NEAR(cv::sum(shade)[0], std::numbers::pi * 40.3 * 40.3, 3);
  const cv::Moments m = [&] {
    cv::Moments sums;
    for (int y = 0; y < shade.rows; ++y)
      for (int x = 0; x < shade.cols; ++x) {
        sums.m00 += shade.at<float>(y, x);
        sums.m10 += x * shade.at<float>(y, x);
        sums.m01 += y * shade.at<float>(y, x);
      }
    return sums;
  }();
  EXPECT_NEAR(m.m10 / m.m00, 85.25, 0.02);
  EXPECT_NEAR(m.m01 / m.m00, 52.5, 0.02);
  EXPECT_EQ(shade.at<float>(52, 85 + 39), 1);
  EXPECT_EQ(shade.at<float>(52, 85 + 42), 0);
}

TEST(Shade, TheReflectionOfTheCameraIsADarkDiscOfItsAngle) {
  LensParameters lens;
  for (const double angle_deg : {0.3, 6.0, 20.0}) {
    lens.reflection_deg = angle_deg;
    const cv::Mat shade = Shade(lens, kCamera);
    const double tan = std::tan(angle_deg * std::numbers::pi / 180);
    const double dark = static_cast<double>(shade.total()) - cv::sum(shade)[0];
    const double area = std::numbers::pi * 70 * tan * 75 * tan;  // an ellipse
    EXPECT_NEAR(dark, area, 0.04 * std::sqrt(area) + 0.05) << angle_deg;
  }
  EXPECT_EQ(Shade(lens, kCamera).at<float>(52, 85), 0);
  EXPECT_EQ(Shade(lens, kCamera).at<float>(0, 0), 1);
}

TEST(Shade, ItsPartsMultiply) {
  LensParameters fall, rim, both;
  fall.cos_power = both.cos_power = 3;
  rim.rim_px = both.rim_px = 45;
  cv::Mat product;
  cv::multiply(Shade(fall, kCamera), Shade(rim, kCamera), product);
  EXPECT_LT(cv::norm(product, Shade(both, kCamera), cv::NORM_INF), 1e-6);
}

// What a point of light becomes.
cv::Mat Spot(const char* shape, double px) {
  LensParameters lens;
  lens.defocus = shape;
  lens.defocus_px = px;
  cv::Mat point(101, 101, CV_32F, cv::Scalar(0));
  point.at<float>(50, 50) = 1000;
  return Defocus(lens).Spread(point);
}

TEST(Defocus, SpreadsAPointWithoutLosingLight) {
  for (const char* shape : {"gaussian", "disc"}) {
    for (const double px : {0.3, 0.7, 1.0, 2.5, 6.0}) {
      const cv::Mat spot = Spot(shape, px);
      double sum = 0, xx = 0, yy = 0, xy = 0, x_sum = 0;
      for (int y = 0; y < 101; ++y)
        for (int x = 0; x < 101; ++x) {
          const double light = spot.at<float>(y, x);
          ASSERT_GE(light, -1e-6);  // a large kernel goes by way of frequencies
          sum += light, x_sum += light * (x - 50);
          xx += light * (x - 50) * (x - 50), yy += light * (y - 50) * (y - 50);
          xy += light * (x - 50) * (y - 50);
        }
      EXPECT_NEAR(sum, 1000, 0.01);
      EXPECT_NEAR(x_sum / sum, 0, 1e-5);
      EXPECT_NEAR(xy / sum, 0, 1e-4);
      EXPECT_NEAR(xx, yy, 1e-3 * sum);
      if (shape[0] == 'g') {
        EXPECT_NEAR(xx / sum, px * px, 2e-3 * px * px) << px;  // of its tails beyond four deviations
      } else if (px > 2) {  // smaller ones are too coarse on the pixels for a formula
        EXPECT_NEAR(xx / sum, px * px / 4 + 1.0 / 12, 0.03 * px * px)
            << px;  // disc, and the pixel's own square
      }
    }
  }
}

TEST(Defocus, ADiscHasAnEdgeAndAGaussianHasNone) {
  const cv::Mat disc = Spot("disc", 6), gaussian = Spot("gaussian", 3);
  EXPECT_FLOAT_EQ(disc.at<float>(50, 50), disc.at<float>(50, 55));
  EXPECT_NEAR(disc.at<float>(50, 50), 1000 / (std::numbers::pi * 36), 0.05);
  EXPECT_NEAR(disc.at<float>(50, 57), 0, 1e-6);
  EXPECT_NEAR(gaussian.at<float>(50, 53) / gaussian.at<float>(50, 50), std::exp(-0.5), 0.02);
}

TEST(Defocus, BeyondItsBorderTheImageGoesOn) {
  LensParameters lens;
  lens.defocus_px = 3;
  const cv::Mat even(30, 40, CV_32F, cv::Scalar(77));
  EXPECT_LT(cv::norm(Defocus(lens).Spread(even), even, cv::NORM_INF), 1e-4);
  EXPECT_TRUE(Defocus(LensParameters{}).sharp());
  EXPECT_FALSE(Defocus(lens).sharp());
}

TEST(Shade, DustTakesTheLightOfItsGrains) {
  LensParameters lens;
  lens.dust = {.count = 1, .size_px = 3, .darkness = 0.4};
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const cv::Mat shade = Shade(lens, kCamera, seed);
    double low = 0, high = 0;
    cv::minMaxLoc(shade, &low, &high);
    EXPECT_NEAR(low, 0.6, 0.02) << seed;
    EXPECT_EQ(high, 1) << seed;
    // The volume of a Gaussian, less of one at the border.
    EXPECT_LE(cv::sum(1 - shade)[0], 0.4 * 2 * std::numbers::pi * 9 + 0.01) << seed;
  }
  lens.dust.count = 400;
  const double lost = cv::mean(1 - Shade(lens, kCamera, 1))[0];
  EXPECT_NEAR(lost, 1 - std::exp(-400 * 0.4 * 2 * std::numbers::pi * 9 / (160 * 120)), 0.12);
  EXPECT_GT(cv::norm(Shade(lens, kCamera, 1), Shade(lens, kCamera, 2), cv::NORM_INF), 0.1);
}

}  // namespace
}  // namespace kestrel::sim
