// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/image_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/landmark/features/features.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Of the points that were followed, how many must agree. A jump that Lucas-Kanade cannot follow leaves a few that
// agree by chance.
constexpr double kAgreeing = 0.35;

cv::Point2f ToCv(const Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

std::optional<ImageMotion> Judge(const std::vector<PointPair>& pairs, MotionModel model, double least_share,
                                 const ImageMotionOptions& options) {
  const RobustMotionOptions robust{.threshold_px = options.threshold_px, .min_inliers = options.min_inliers};
  const auto fit = FitRobustMotion(pairs, model, robust);
  if (!fit || static_cast<double>(fit->inliers.size()) < least_share * static_cast<double>(pairs.size()))
    return std::nullopt;
  ImageMotion motion;
  motion.H = fit->H, motion.rms_px = fit->rms_px, motion.points = static_cast<int>(pairs.size());
  for (const int i : fit->inliers) motion.inliers.push_back(pairs[static_cast<std::size_t>(i)]);
  return motion;
}

std::optional<ImageMotion> ByLucasKanade(MotionImage& from, const MotionImage& to,
                                         const std::optional<Matrix3d>& H_expected, MotionModel model,
                                         const ImageMotionOptions& options) {
  std::vector<cv::Point2f> begin, end;
  for (const cv::Point2f& p : from.Corners(options.max_points)) {
    if (!H_expected) {
      begin.push_back(p);
      continue;
    }
    const cv::Point2f there = ToCv(Transfer(*H_expected, {p.x, p.y}));
    if (!cv::Rect2f(0, 0, static_cast<float>(to.grey().cols), static_cast<float>(to.grey().rows))
             .contains(there))
      continue;
    begin.push_back(p), end.push_back(there);
  }
  if (static_cast<int>(begin.size()) < options.min_inliers) return std::nullopt;
  const std::vector<std::uint8_t> found = FollowPoints(from.pyramid(), to.pyramid(), begin, end);
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < begin.size(); ++i)
    if (found[i]) pairs.push_back({{begin[i].x, begin[i].y}, {end[i].x, end[i].y}});
  return Judge(pairs, model, kAgreeing, options);
}

std::optional<ImageMotion> ByFeatures(const cv::Mat& from, const cv::Mat& to, FeatureDetector detector,
                                      MotionModel model, const ImageMotionOptions& options) {
  const FeatureOptions of{.detector = detector, .max_features = std::max(500, options.max_points)};
  const Features a = Detect(from, of), b = Detect(to, of);
  std::vector<PointPair> pairs;
  for (const Match& match : MatchFeatures(a, b, {.ratio = 0.8F, .mutual = true})) {
    const cv::Point2f &p = a.points[static_cast<std::size_t>(match.a)].pt,
                      &q = b.points[static_cast<std::size_t>(match.b)].pt;
    pairs.push_back({{p.x, p.y}, {q.x, q.y}});
  }
  return Judge(pairs, model, 0.2, options);
}

// Where Lucas-Kanade has lost the way: by features, the quick ones first, and then by Lucas-Kanade from there, which
// is finer.
std::optional<ImageMotion> Recover(MotionImage& from, const MotionImage& to, MotionModel model,
                                   const ImageMotionOptions& options) {
  ImageMotionOptions coarse = options;
  coarse.threshold_px = std::max(3.0, options.threshold_px);
  for (const FeatureDetector detector : {FeatureDetector::kOrb, FeatureDetector::kSift}) {
    const auto rough = ByFeatures(from.grey(), to.grey(), detector, model, coarse);
    if (!rough) continue;
    auto fine = ByLucasKanade(from, to, rough->H, model, options);
    ImageMotion motion = fine ? *std::move(fine) : *rough;
    motion.state = MotionState::kRecovered;
    return motion;
  }
  return std::nullopt;
}

}  // namespace

const char* NameOf(MotionState state) {
  switch (state) {
    case MotionState::kFollowed:
      return "followed";
    case MotionState::kRecovered:
      return "recovered";
    case MotionState::kTextureless:
      return "textureless";
    case MotionState::kCut:
      return "cut";
    case MotionState::kResized:
      return "resized";
  }
  return "";
}

MotionImage::MotionImage(const cv::Mat& grey, bool with_pyramid, bool opencl) : grey_(grey) {
  if (with_pyramid) pyramid_ = FlowPyramid(grey_, {.opencl = opencl});
}

const std::vector<cv::Point2f>& MotionImage::Corners(int max_points) {
  if (asked_ == max_points || grey_.empty()) return corners_;
  asked_ = max_points;
  cv::Mat half;
  cv::resize(grey_, half, {}, 0.5, 0.5, cv::INTER_AREA);
  const double apart = std::sqrt(static_cast<double>(half.total()) / max_points) * 0.6;
  cv::goodFeaturesToTrack(half, corners_, max_points, 0.005, std::max(3.0, apart), cv::noArray(), 3);
  // What has less contrast than noise is no corner, however it compares with the best.
  constexpr float kContrast_grey = 3;
  std::erase_if(corners_, [&](const cv::Point2f& p) {
    cv::Scalar mean, deviation;
    const cv::Rect around =
        cv::Rect(static_cast<int>(p.x) - 3, static_cast<int>(p.y) - 3, 7, 7) & cv::Rect({}, half.size());
    cv::meanStdDev(half(around), mean, deviation);
    return deviation[0] < kContrast_grey;
  });
  for (cv::Point2f& p : corners_) p = {2 * p.x + 0.5F, 2 * p.y + 0.5F};
  return corners_;
}

ImageMotion MotionBetween(MotionImage& from, MotionImage& to, const std::optional<Matrix3d>& H_expected,
                          const ImageMotionOptions& options) {
  ImageMotion motion;
  const MotionModel model = MotionModelNamed(options.model).value_or(MotionModel::kHomography);
  if (from.grey().size() != to.grey().size()) {
    motion.state = MotionState::kResized;
    return motion;
  }
  std::optional<ImageMotion> found;
  if (options.method == "lk") {
    if (static_cast<int>(from.Corners(options.max_points).size()) < options.min_inliers) return motion;
    found = ByLucasKanade(from, to, H_expected, model, options);
    if (found) {
      found->state = MotionState::kFollowed;
      return *found;
    }
    if (static_cast<int>(to.Corners(options.max_points).size()) < options.min_inliers) return motion;
    found = Recover(from, to, model, options);
  } else {
    found = ByFeatures(from.grey(), to.grey(), *FeatureDetectorNamed(options.method), model, options);
    if (found) found->state = MotionState::kFollowed;
    if (!found && (static_cast<int>(from.Corners(options.max_points).size()) < options.min_inliers ||
                   static_cast<int>(to.Corners(options.max_points).size()) < options.min_inliers))
      return motion;
  }
  if (found) return *found;
  motion.state = MotionState::kCut;
  return motion;
}

}  // namespace kestrel::vision
