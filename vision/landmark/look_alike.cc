// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/look_alike.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/landmark/even_light.h"

namespace kestrel::vision {
namespace {

constexpr double kCoarseView_px = 45;  // at least, of the shorter side
constexpr int kCoarseEvened_px = 9, kCoarseShift_px = 3;
constexpr int kMinCoarse_px2 = 64;  // that are in view
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

// The image seen by the pixels of a level of the reference.
cv::Mat InPixelsOf(const PadReference::Level& level, const cv::Mat& image, const Eigen::Matrix3d& H_w,
                   int interpolation, cv::BorderTypes border = cv::BORDER_CONSTANT) {
  cv::Mat map, view;
  cv::eigen2cv(Eigen::Matrix3d(H_w * level.pixel_from_T.inverse()), map);
  cv::warpPerspective(image, view, map, level.image.size(), interpolation | cv::WARP_INVERSE_MAP, border);
  return view;
}

// Which pixels of a level an image of that size shows: 255, and 0.
cv::Mat InView(const PadReference::Level& level, const cv::Size& image, const Eigen::Matrix3d& H_w) {
  return InPixelsOf(level, cv::Mat(image, CV_8UC1, cv::Scalar(255)), H_w, cv::INTER_NEAREST);
}

}  // namespace

double CoarseLikeness(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w) {
  const PadReference::Level& level =
      reference.LevelFor(kCoarseView_px / std::min(reference.length_m, reference.width_m));
  const cv::Rect inner(kCoarseShift_px, kCoarseShift_px, level.image.cols - 2 * kCoarseShift_px,
                       level.image.rows - 2 * kCoarseShift_px);
  const cv::Mat seen = InView(level, grey.size(), H_w);
  if (inner.empty() || cv::countNonZero(seen(inner)) < kMinCoarse_px2) return 1;
  const cv::Mat view = InPixelsOf(level, grey, H_w, cv::INTER_AREA, cv::BORDER_REPLICATE);
  cv::Mat likeness;
  cv::matchTemplate(EvenlyLit(view, kCoarseEvened_px, seen),
                    EvenlyLit(level.image, kCoarseEvened_px, seen)(inner), likeness, cv::TM_CCOEFF_NORMED,
                    seen(inner));
  cv::patchNaNs(likeness, 1);  // of an even picture
  double most = 0;
  cv::minMaxLoc(likeness, nullptr, &most);
  return most;
}

bool LooksMirrored(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w) {
  const PadReference::Level& level = reference.LevelFor(kMirrored_px_per_m);
  const cv::Mat view = InPixelsOf(level, grey, H_w, cv::INTER_AREA);
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
  const cv::Size size = level.image.size();
  const cv::Mat view = InPixelsOf(level, grey, H_w, cv::INTER_LINEAR), seen = InView(level, grey.size(), H_w);
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
