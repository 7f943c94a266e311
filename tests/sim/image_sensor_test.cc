// SPDX-License-Identifier: Apache-2.0
#include "sim/image_sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel {
namespace {

const cv::Size kSize(320, 240);
const Pinhole kCamera{320, 240, 300, 300, 159.5, 119.5};

cv::Mat Grey(int level) { return cv::Mat(kSize, CV_8UC3, cv::Scalar::all(level)); }

// Noise of a frame: what the sensor made of an even grey of 128, less that.
cv::Mat Noise(const ImageSensor& sensor, std::int64_t sequence) {
  cv::Mat noise;
  sensor.Expose(Grey(128), sequence).convertTo(noise, CV_64F);
  return noise - cv::Scalar::all(128);
}

double Correlation(const cv::Mat& a, const cv::Mat& b) { return a.dot(b) / std::sqrt(a.dot(a) * b.dot(b)); }

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(ImageSensor, WithoutNoiseItPassesTheImageOn) {
  ImageParameters p;
  p.noise_grey = 0;
  cv::Mat bgr(kSize, CV_8UC3);
  cv::randu(bgr, 0, 256);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  EXPECT_TRUE(Same(ImageSensor(p, kCamera, 1).Expose(bgr, 7), grey));
  p.colour = true;
  EXPECT_TRUE(Same(ImageSensor(p, kCamera, 1).Expose(bgr, 7), bgr));
}

TEST(ImageSensor, NoiseHasItsDeviationAndNoMean) {
  for (const double sigma : {1.0, 2.0, 8.0}) {
    ImageParameters p;
    p.noise_grey = sigma;
    const ImageSensor sensor(p, kCamera, 3);
    double sum = 0, squares = 0;
    constexpr int kFrames = 8;
    for (int i = 0; i < kFrames; ++i) {
      const cv::Mat noise = Noise(sensor, i);
      sum += cv::sum(noise)[0];
      squares += noise.dot(noise);
    }
    const double n = kFrames * static_cast<double>(kSize.area());
    EXPECT_NEAR(sum / n, 0, 0.02 * sigma);
    EXPECT_NEAR(squares / n, sigma * sigma + 1.0 / 12, 0.03 * sigma * sigma);  // rounding adds a twelfth
  }
}

TEST(ImageSensor, NoiseIsWhiteInTheImageAndInTime) {
  const ImageSensor sensor({}, kCamera, 4);
  const cv::Mat first = Noise(sensor, 0);
  constexpr double kBound = 0.02;  // five deviations for 76800 pixels
  EXPECT_LT(std::abs(Correlation(first, Noise(sensor, 1))), kBound);
  EXPECT_LT(std::abs(Correlation(first, Noise(sensor, 1000))), kBound);
  const int w = kSize.width, h = kSize.height;
  for (const cv::Point shift : {cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1), cv::Point(7, 2)}) {
    const cv::Rect here(0, 0, w - shift.x, h - shift.y);
    EXPECT_LT(std::abs(Correlation(first(here).clone(), first(here + shift).clone())), kBound) << shift;
  }
}

TEST(ImageSensor, SeedAndSequenceAloneDecide) {
  const ImageSensor a({}, kCamera, 5), again({}, kCamera, 5), other({}, kCamera, 6);
  const cv::Mat bgr = Grey(90);
  // in another order, and by another sensor of the same seed
  const cv::Mat third = a.Expose(bgr, 3), first = a.Expose(bgr, 1);
  EXPECT_TRUE(Same(first, again.Expose(bgr, 1)));
  EXPECT_TRUE(Same(third, again.Expose(bgr, 3)));
  EXPECT_TRUE(Same(third, a.Expose(bgr, 3)));
  EXPECT_FALSE(Same(first, third));
  EXPECT_FALSE(Same(first, other.Expose(bgr, 1)));
}

TEST(ImageSensor, BlackAndWhiteAreTheEndsOfTheScale) {
  ImageParameters p;
  p.noise_grey = 20;
  const ImageSensor sensor(p, kCamera, 7);
  for (const int level : {0, 255}) {
    const cv::Mat image = sensor.Expose(Grey(level), 0);
    const double clipped = cv::countNonZero(image == level) / static_cast<double>(kSize.area());
    EXPECT_NEAR(clipped, 0.5,
                0.03);  // half the noise would go beyond, and must not come round at the other end
    EXPECT_EQ(cv::countNonZero(cv::abs(image - level) > 120), 0);
  }
}

TEST(ImageSensor, EachChannelOfColourHasNoiseOfItsOwn) {
  ImageParameters p;
  p.colour = true;
  const cv::Mat noise = Noise(ImageSensor(p, kCamera, 8), 2);
  ASSERT_EQ(noise.channels(), 3);
  cv::Mat channels[3];
  cv::split(noise, channels);
  for (const cv::Mat& c : channels)
    EXPECT_NEAR(std::sqrt(c.dot(c) / kSize.area()), std::sqrt(4 + 1.0 / 12), 0.06);
  EXPECT_LT(std::abs(Correlation(channels[0], channels[1])), 0.02);
  EXPECT_LT(std::abs(Correlation(channels[1], channels[2])), 0.02);
}

TEST(ImageSensor, TheRenderedImageIsLeftAsItWas) {
  const cv::Mat bgr = Grey(50);
  ImageParameters p;
  p.colour = true;
  ImageSensor(p, kCamera, 9).Expose(bgr, 0);
  EXPECT_TRUE(Same(bgr, Grey(50)));
}

}  // namespace
}  // namespace kestrel
