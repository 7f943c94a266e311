// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/blank_image.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

constexpr int kPixels = 8;          // to a side, averaged: against noise
constexpr double kMinSpread = 1.5;  // grey levels, standard deviation of these means

}  // namespace

bool Blank(const cv::Mat& image) {
  if (image.empty()) return true;
  cv::Mat small, spread, mean;
  cv::resize(image, small, {std::max(1, image.cols / kPixels), std::max(1, image.rows / kPixels)}, 0, 0,
             cv::INTER_AREA);
  cv::meanStdDev(small, mean, spread);
  return cv::norm(spread, cv::NORM_INF) < kMinSpread;
}

}  // namespace kestrel::vision
