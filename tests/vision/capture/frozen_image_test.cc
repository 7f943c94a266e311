// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/frozen_image.h"

#include <gtest/gtest.h>

namespace kestrel::vision {
namespace {

cv::Mat Noise(int seed, int type = CV_8UC3, const cv::Size& size = {32, 24}) {
  cv::Mat image(size, type);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

TEST(FrozenImage, OnlyARepetitionOfTheImageBeforeIs) {
  FrozenImage frozen;
  EXPECT_FALSE(frozen.Is(Noise(1)));
  EXPECT_TRUE(frozen.Is(Noise(1)));
  EXPECT_TRUE(frozen.Is(Noise(1)));
  EXPECT_FALSE(frozen.Is(Noise(2)));
  EXPECT_FALSE(frozen.Is(Noise(1)));  // seen before, but not just before
}

TEST(FrozenImage, OneBitAnywhereMakesAnotherImage) {
  for (const cv::Point& at : {cv::Point(0, 0), cv::Point(31, 0), cv::Point(31, 23)}) {
    FrozenImage frozen;
    cv::Mat image = Noise(1);
    frozen.Is(image);
    image.at<cv::Vec3b>(at)[2] ^= 1;  // in the same memory: what is compared is a copy
    EXPECT_FALSE(frozen.Is(image)) << at;
  }
}

TEST(FrozenImage, TheImageCountsAndNotHowItLiesInMemory) {
  const cv::Mat large = Noise(1, CV_8UC3, {40, 30});
  const cv::Mat part = large(cv::Rect(3, 2, 32, 24));
  FrozenImage frozen;
  EXPECT_FALSE(frozen.Is(part));
  EXPECT_TRUE(frozen.Is(part.clone()));
}

TEST(FrozenImage, AnotherSizeOrTypeOfTheSameBytesIsAnother) {
  const cv::Mat image = Noise(1, CV_8UC1);
  FrozenImage frozen;
  frozen.Is(image);
  EXPECT_FALSE(frozen.Is(image.reshape(1, 12)));
  EXPECT_FALSE(frozen.Is(image));
  EXPECT_FALSE(frozen.Is(image.reshape(3, 8)));
}

TEST(FrozenImage, AnEmptyImageRepeatsNothing) {
  FrozenImage frozen;
  EXPECT_FALSE(frozen.Is({}));
  EXPECT_FALSE(frozen.Is({}));
  EXPECT_FALSE(frozen.Is(Noise(1)));
  EXPECT_FALSE(frozen.Is({}));
}

}  // namespace
}  // namespace kestrel::vision
