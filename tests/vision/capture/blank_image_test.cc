// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/blank_image.h"

#include <gtest/gtest.h>

namespace kestrel::vision {
namespace {

cv::Mat Noisy(int type, const cv::Scalar& colour, double noise) {
  cv::Mat image(480, 640, type, colour), errors(image.size(), CV_MAKETYPE(CV_16S, image.channels()));
  cv::RNG(7).fill(errors, cv::RNG::NORMAL, 0, noise);
  cv::add(image, errors, image, {}, type);
  return image;
}

TEST(BlankImage, NoiseAloneIsNothingWhateverItsLevel) {
  for (const double level : {0.0, 3.0, 128.0, 255.0}) {
    EXPECT_TRUE(Blank(Noisy(CV_8UC1, cv::Scalar::all(level), 6))) << level;
    EXPECT_TRUE(Blank(Noisy(CV_8UC3, cv::Scalar::all(level), 6))) << level;
  }
  EXPECT_TRUE(Blank({}));
}

TEST(BlankImage, AHorizonInTheDuskIsSomething) {
  cv::Mat image = Noisy(CV_8UC3, {20, 15, 12}, 3);
  image.rowRange(240, 480) -= cv::Scalar(8, 5, 4);
  EXPECT_FALSE(Blank(image));
}

TEST(BlankImage, OneColourMayDifferAndNotTheLight) {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar(100, 100, 100));
  image.colRange(0, 100).setTo(cv::Scalar(100, 100, 120));
  EXPECT_FALSE(Blank(image));
}

}  // namespace
}  // namespace kestrel::vision
