// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_features.h"

#include <Eigen/LU>
#include <opencv2/features2d.hpp>

#include "vision/landmark/homography.h"
#include "vision/landmark/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr double kReference_px_per_m = 500;  // blocks and polygons down to a centimetre
constexpr int kReferenceFeatures = 2500;
constexpr int kImageFeatures = 500;
constexpr float kDistinct = 0.8F;  // a match is kept if the second best is this much worse (Lowe)
constexpr double kThreshold_px = 3;
constexpr int kMinInliers = 12;

}  // namespace

PadFeatures::PadFeatures(const PadReference& reference, const Pinhole& camera) : camera_(camera) {
  const PadReference::Level& level = reference.LevelFor(kReference_px_per_m);
  std::vector<cv::KeyPoint> found;
  cv::SIFT::create(kReferenceFeatures)->detectAndCompute(level.image, cv::noArray(), found, descriptors_);
  const Eigen::Matrix3d T_from_pixel = level.pixel_from_T.inverse();
  for (const cv::KeyPoint& k : found) places_.push_back(Transfer(T_from_pixel, {k.pt.x, k.pt.y}));
}

std::optional<Eigen::Matrix3d> PadFeatures::Find(const cv::Mat& grey, std::uint32_t seed) const {
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  cv::SIFT::create(kImageFeatures)->detectAndCompute(grey, cv::noArray(), found, descriptors);
  if (found.size() < static_cast<std::size_t>(kMinInliers) || places_.size() < 2) return std::nullopt;
  // Every pair is compared: an approximate search would depend on a random forest of its own.
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_L2).knnMatch(descriptors, descriptors_, matches, 2);
  std::vector<PointPair> pairs;  // both sides in pixels of about the image's size, for one threshold
  const double scale = kReference_px_per_m;
  for (const auto& m : matches) {
    if (m.size() < 2 || !(m[0].distance < kDistinct * m[1].distance)) continue;
    const cv::Point2f& at = found[m[0].queryIdx].pt;
    pairs.push_back({scale * places_[m[0].trainIdx], {at.x, at.y}});
  }
  const auto robust = RansacHomography(
      pairs, {.threshold = kThreshold_px, .max_trials = 2000, .min_inliers = kMinInliers}, seed);
  if (!robust) return std::nullopt;
  const Eigen::Matrix3d H_w = robust->H * Eigen::Vector3d(scale, scale, 1).asDiagonal();
  if (!PoseFromHomography(H_w, camera_)) return std::nullopt;
  return H_w;
}

}  // namespace kestrel::vision
