// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_features.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr double kReference_px_per_m = 500;  // blocks and polygons down to a centimetre
constexpr int kReferenceFeatures = 2500;
constexpr double kThreshold_px = 3;
constexpr int kMinInliers = 12;
constexpr int kHalvedFrom_px = 400;

// Those of the other detectors are cheaper, and fewer of them are right.
int ImageFeatures(FeatureDetector detector) { return detector == FeatureDetector::kSift ? 500 : 1000; }

}  // namespace

PadFeatures::PadFeatures(const PadReference& reference, const Pinhole& camera, FeatureDetector detector)
    : camera_(camera), detector_(detector) {
  const PadReference::Level& level = reference.LevelFor(kReference_px_per_m);
  reference_ = Detect(level.image, {detector_, kReferenceFeatures});
  const Eigen::Matrix3d T_from_pixel = level.pixel_from_T.inverse();
  for (const cv::KeyPoint& k : reference_.points) places_.push_back(Transfer(T_from_pixel, {k.pt.x, k.pt.y}));
}

std::optional<Eigen::Matrix3d> PadFeatures::Find(const cv::Mat& grey, std::uint32_t seed) const {
  // SIFT looks for its finest in an image of twice the size, where it spends most of its time.
  const bool halved = detector_ == FeatureDetector::kSift && grey.rows >= kHalvedFrom_px;
  cv::Mat half;
  if (halved) cv::resize(grey, half, {grey.cols / 2, grey.rows / 2}, 0, 0, cv::INTER_AREA);
  Features found = Detect(halved ? half : grey, {detector_, ImageFeatures(detector_)});
  if (halved) {
    for (cv::KeyPoint& k : found.points) k.pt = 2 * k.pt + cv::Point2f(0.5F, 0.5F);
  }
  std::vector<PointPair> pairs;  // both sides in pixels of about the image's size, for one threshold
  const double scale = kReference_px_per_m;
  for (const Match& match : MatchFeatures(found, reference_, {})) {
    const cv::Point2f& at = found.points[match.a].pt;
    pairs.push_back({scale * places_[match.b], {at.x, at.y}});
  }
  const auto robust = RansacHomography(
      pairs, {.threshold = kThreshold_px, .max_trials = 2000, .min_inliers = kMinInliers}, seed);
  if (!robust) return std::nullopt;
  const Eigen::Matrix3d H_w = robust->H * Eigen::Vector3d(scale, scale, 1).asDiagonal();
  if (!PoseFromHomography(H_w, camera_)) return std::nullopt;
  return H_w;
}

}  // namespace kestrel::vision
