// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/mirrored.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace kestrel::vision {
namespace {

constexpr double kMirrored_px_per_m = 60;
constexpr double kClearlyMore = 0.1;  // of the correlation

double Likeness(const cv::Mat& view, const cv::Mat& picture) {
  cv::Mat correlation;
  cv::matchTemplate(view, picture, correlation, cv::TM_CCOEFF_NORMED);
  return correlation.at<float>(0, 0);
}

}  // namespace

bool LooksMirrored(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w) {
  const PadReference::Level& level = reference.LevelFor(kMirrored_px_per_m);
  cv::Mat map, view;
  cv::eigen2cv(Eigen::Matrix3d(H_w * level.pixel_from_T.inverse()), map);
  cv::warpPerspective(grey, view, map, level.image.size(), cv::INTER_AREA | cv::WARP_INVERSE_MAP);
  std::vector<cv::Mat> mirrored(2);
  cv::flip(level.image, mirrored[0], 0);
  cv::flip(level.image, mirrored[1], 1);
  if (level.image.cols == level.image.rows && std::abs(reference.length_m - reference.width_m) < 0.05) {
    // Of a square also about its diagonals.
    cv::transpose(level.image, mirrored.emplace_back());
    cv::rotate(cv::Mat(mirrored[2]), mirrored.emplace_back(), cv::ROTATE_180);
  }
  const double straight = Likeness(view, level.image);
  return std::any_of(mirrored.begin(), mirrored.end(), [&](const cv::Mat& picture) {
    return Likeness(view, picture) > straight + kClearlyMore;
  });
}

}  // namespace kestrel::vision
