// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/even_light.h"

#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

constexpr double kLeastDeviation_grey = 2;
constexpr double kLeastShare = 1e-6;  // of a square: none of it

}  // namespace

cv::Mat EvenlyLit(const cv::Mat& grey, int side_px, const cv::Mat& mask) {
  cv::Mat light, mean, squares;
  grey.convertTo(light, CV_32F);
  const cv::Mat counted = mask.empty() ? light : cv::Mat::zeros(light.size(), CV_32F);
  if (!mask.empty()) light.copyTo(counted, mask);
  const cv::Size side(side_px, side_px);
  cv::boxFilter(counted, mean, CV_32F, side, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::sqrBoxFilter(counted, squares, CV_32F, side, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::Mat share;  // of the square that counts
  if (!mask.empty()) {
    mask.convertTo(share, CV_32F, 1.0 / 255);
    cv::boxFilter(share, share, CV_32F, side, {-1, -1}, true, cv::BORDER_REFLECT);
    cv::max(share, kLeastShare, share);
    mean /= share;
    squares /= share;
  }
  cv::Mat deviation = squares - mean.mul(mean);
  cv::max(deviation, kLeastDeviation_grey * kLeastDeviation_grey, deviation);
  cv::sqrt(deviation, deviation);
  cv::Mat even = (light - mean) / deviation;
  if (!mask.empty()) even.setTo(0, share <= kLeastShare);
  return even;
}

}  // namespace kestrel::vision
