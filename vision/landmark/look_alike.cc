// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/look_alike.h"

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
constexpr double kRimView_px = 110;   // shorter side of the picture in which the rim is compared
constexpr int kRimPatch_px = 11, kRimStep_px = 5;
constexpr double kMinRimSigma_grey = 6, kMinRimLikeness = 0.5;
constexpr int kMinRimPatches = 8;      // that have marks
constexpr double kMinRimShare = 0.55;  // of those: something may hide the others

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

bool RimAgrees(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w) {
  const PadReference::Level& level =
      reference.LevelFor(kRimView_px / std::min(reference.length_m, reference.width_m));
  const Eigen::Matrix3d image_from_level = H_w * level.pixel_from_T.inverse();
  cv::Mat map, view, seen;
  cv::eigen2cv(image_from_level, map);
  const cv::Size size = level.image.size();
  cv::warpPerspective(grey, view, map, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  cv::warpPerspective(cv::Mat(grey.size(), CV_8UC1, cv::Scalar(255)), seen, map, size,
                      cv::INTER_NEAREST | cv::WARP_INVERSE_MAP);
  const cv::Rect middles(kRimPatch_px / 2 + 1, kRimPatch_px / 2 + 1, size.width - kRimPatch_px - 2,
                         size.height - kRimPatch_px - 2);
  if (middles.width < kRimPatch_px || middles.height < kRimPatch_px) return true;
  int patches = 0, alike = 0;
  const auto compare = [&](int x, int y) {
    const cv::Rect patch(x - kRimPatch_px / 2, y - kRimPatch_px / 2, kRimPatch_px, kRimPatch_px);
    cv::Scalar mean, sigma;
    cv::meanStdDev(level.image(patch), mean, sigma);
    if (!(sigma[0] > kMinRimSigma_grey) || cv::countNonZero(seen(patch)) < patch.area()) return;
    ++patches;
    alike += Likeness(view(patch), level.image(patch)) > kMinRimLikeness;
  };
  for (int x = middles.x; x < middles.x + middles.width; x += kRimStep_px)
    compare(x, middles.y), compare(x, middles.y + middles.height - 1);
  for (int y = middles.y + kRimStep_px; y < middles.y + middles.height - 1; y += kRimStep_px)
    compare(middles.x, y), compare(middles.x + middles.width - 1, y);
  return patches < kMinRimPatches || alike >= kMinRimShare * patches;
}

}  // namespace kestrel::vision
