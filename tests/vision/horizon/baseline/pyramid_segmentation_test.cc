// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/baseline/pyramid_segmentation.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>

namespace kestrel::vision {
namespace {

std::set<int> ValuesOf(const cv::Mat& image) {
  std::set<int> values;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) values.insert(image.at<uchar>(y, x));
  return values;
}

TEST(PyramidSegmentation, ANoisyDiscOnANoisyGroundBecomesTwoTonesWithItsEdgeInPlace) {
  cv::Mat clean(123, 161, CV_8UC1, cv::Scalar(60)), noise(clean.size(), CV_8SC1), image;
  cv::circle(clean, {80, 60}, 35, cv::Scalar(170), cv::FILLED);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, -4, 5);
  cv::add(clean, noise, image, {}, CV_8U);
  const cv::Mat segments = SegmentByPyramid(image);
  ASSERT_EQ(segments.size(), image.size());
  int wrong = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      wrong += std::abs(segments.at<uchar>(y, x) - clean.at<uchar>(y, x)) > 4;
  EXPECT_LT(wrong, image.rows * image.cols / 200);
  EXPECT_LT(ValuesOf(segments).size(), ValuesOf(image).size());
}

TEST(PyramidSegmentation, OneToneStaysAsItIs) {
  EXPECT_EQ(ValuesOf(SegmentByPyramid(cv::Mat(40, 31, CV_8UC1, cv::Scalar(77)))), std::set<int>{77});
}

TEST(PyramidSegmentation, SegmentsThatAreAlikeBecomeOneWhereverTheyAre) {
  cv::Mat image(64, 64, CV_8UC1, cv::Scalar(20));
  image(cv::Rect(4, 4, 16, 16)).setTo(200);
  image(cv::Rect(40, 40, 16, 16)).setTo(202);
  const cv::Mat segments = SegmentByPyramid(image);
  EXPECT_EQ(segments.at<uchar>(12, 12), segments.at<uchar>(48, 48));
}

}  // namespace
}  // namespace kestrel::vision
