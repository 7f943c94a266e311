// SPDX-License-Identifier: Apache-2.0
#include "vision/interlaced.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

const cv::Size kSize(320, 240);

cv::Mat Scene() {
  cv::Mat fine(300, 400, CV_32FC1), scene;
  cv::RNG(5).fill(fine, cv::RNG::NORMAL, 0, 120);
  cv::GaussianBlur(fine, fine, {}, 2.5);
  fine.convertTo(scene, CV_8U, 3, 128);
  return scene;
}

cv::Mat Seen(int place) { return Scene()(cv::Rect({place, 20}, kSize)).clone(); }

// The rows of the first field are of one time, the others of another.
cv::Mat Woven(int from, int until) {
  cv::Mat image = Seen(from);
  const cv::Mat later = Seen(until);
  for (int r = 1; r < image.rows; r += 2) later.row(r).copyTo(image.row(r));
  return image;
}

TEST(Interlaced, IsAnImageOfTwoFieldsBetweenWhichTheCameraMoved) {
  for (const int step : {4, 8, 30}) EXPECT_TRUE(Interlaced(Woven(10, 10 + step))) << step;
  cv::Mat colour;
  cv::cvtColor(Woven(10, 20), colour, cv::COLOR_GRAY2BGR);
  EXPECT_TRUE(Interlaced(colour));
}

TEST(Interlaced, IsNoWholeImage) {
  EXPECT_FALSE(Interlaced(Seen(10)));
  EXPECT_FALSE(Interlaced(Woven(10, 10)));
  cv::Mat noise(kSize, CV_8UC1);
  cv::RNG(8).fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_FALSE(Interlaced(noise));
  EXPECT_FALSE(Interlaced(cv::Mat(kSize, CV_8UC1, cv::Scalar(90))));
  EXPECT_FALSE(Interlaced(cv::Mat()));
}

// A person walks through a picture that stands still.
TEST(Interlaced, IsAnImageInWhichAPartMoved) {
  cv::Mat image = Seen(10);
  Woven(10, 20)(cv::Rect(100, 60, 80, 120)).copyTo(image(cv::Rect(100, 60, 80, 120)));
  EXPECT_TRUE(Interlaced(image));
}

TEST(Interlaced, TheFirstFieldIsOfOneTime) {
  const cv::Mat field = FirstField(Woven(10, 30)), seen = Seen(10);
  EXPECT_FALSE(Interlaced(field));
  int rows = 0;
  for (int r = 0; r + 2 < seen.rows; r += 2, ++rows) {
    EXPECT_EQ(cv::norm(field.row(r), seen.row(r), cv::NORM_INF), 0);
    cv::Mat mean;
    cv::addWeighted(seen.row(r), 0.5, seen.row(r + 2), 0.5, 0, mean);
    EXPECT_EQ(cv::norm(field.row(r + 1), mean, cv::NORM_INF), 0);
  }
  EXPECT_EQ(rows, 119);
}

}  // namespace
}  // namespace kestrel::vision
