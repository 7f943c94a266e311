// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_features.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "base/recent/recent.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

// Blocks and polygons down to a centimetre; and what is left of them far away, where the finer features are not
// seen and would take all places of a limited number.
constexpr std::array<double, 3> kReference_px_per_m = {500, 120, 60};
constexpr double kMatched_px_per_m = 500;  // pairs are compared in pixels of about an image's size
constexpr double kThreshold_px = 3;
constexpr int kMinInliers = 12;
constexpr int kHalvedFrom_px = 400;

// How many, the strongest: those of the other detectors are cheaper, and fewer of them are right.
int ImageFeatures(FeatureDetector detector) { return detector == FeatureDetector::kSift ? 350 : 1000; }
int ReferenceFeatures(FeatureDetector detector) { return detector == FeatureDetector::kSift ? 1000 : 2500; }

// A small pad: a part of the image that it fills is this share of the image's width.
constexpr double kPart = 0.375, kSmall = 0.1;
constexpr int kContrastScale = 4;   // of the smaller image that contrast is measured in
constexpr double kBlack_grey = 10;  // noise is no contrast, however dark it is

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size()) return false;
  for (int y = 0; y < a.rows; ++y)
    if (std::memcmp(a.ptr(y), b.ptr(y), static_cast<std::size_t>(a.cols)) != 0) return false;
  return true;
}

// What the features of a reference depend on.
struct OfReference {
  FeatureDetector detector;
  std::vector<PadReference::Level> levels;

  bool operator==(const OfReference& other) const {
    return detector == other.detector &&
           std::equal(levels.begin(), levels.end(), other.levels.begin(), other.levels.end(),
                      [](const PadReference::Level& a, const PadReference::Level& b) {
                        return a.pixel_from_T == b.pixel_from_T && SamePixels(a.image, b.image);
                      });
  }
};

// The part of this rank: around the largest deviation of grey as a share of grey, over a small pad's size, that lies
// in no part of lower rank.
cv::Rect PartOfMostContrast(const cv::Mat& grey, int rank) {
  cv::Mat small, mean, squares;
  cv::resize(grey, small, grey.size() / kContrastScale, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F);
  const int side_px = std::max(3, static_cast<int>(kSmall * small.cols));
  cv::boxFilter(small, mean, CV_32F, {side_px, side_px}, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::sqrBoxFilter(small, squares, CV_32F, {side_px, side_px}, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::Mat contrast = squares - mean.mul(mean);
  cv::max(contrast, 0, contrast);
  cv::sqrt(contrast, contrast);
  contrast /= mean + kBlack_grey;
  const cv::Size part(cvRound(kPart * grey.cols), cvRound(kPart * grey.rows));
  cv::Rect found;
  for (int k = 0; k <= rank; ++k) {
    cv::Point middle;
    cv::minMaxLoc(contrast, nullptr, nullptr, nullptr, &middle);
    middle *= kContrastScale;
    found = {std::clamp(middle.x - part.width / 2, 0, grey.cols - part.width),
             std::clamp(middle.y - part.height / 2, 0, grey.rows - part.height), part.width, part.height};
    const cv::Rect looked(found.x / kContrastScale, found.y / kContrastScale, found.width / kContrastScale,
                          found.height / kContrastScale);
    contrast(looked & cv::Rect({0, 0}, contrast.size())).setTo(0);
  }
  return found;
}

}  // namespace

PadFeatures::PadFeatures(const PadReference& reference, const Pinhole& camera, FeatureDetector detector)
    : camera_(camera), detector_(detector), scales_(ScalesOf(reference, detector)) {}

std::shared_ptr<const std::vector<PadFeatures::Scale>> PadFeatures::ScalesOf(const PadReference& reference,
                                                                             FeatureDetector detector) {
  static Recent<OfReference, std::vector<Scale>> recent(1);
  OfReference of{detector, {}};
  for (const double px_per_m : kReference_px_per_m) {
    const PadReference::Level& level = reference.LevelFor(px_per_m);
    if (of.levels.empty() || of.levels.back().image.data != level.image.data) of.levels.push_back(level);
  }
  return recent.Of(of, [&] {
    std::vector<Scale> scales;
    for (const PadReference::Level& level : of.levels) {
      Scale& scale = scales.emplace_back(Detect(level.image, {detector, ReferenceFeatures(detector)}));
      const Eigen::Matrix3d T_from_pixel = level.pixel_from_T.inverse();
      for (const cv::KeyPoint& k : scale.features.points)
        scale.places.push_back(Transfer(T_from_pixel, {k.pt.x, k.pt.y}));
    }
    return scales;
  });
}

// SIFT looks for its finest in an image of twice the size, where it spends most of its time.
bool PadFeatures::Halves(const cv::Mat& grey) const {
  return detector_ == FeatureDetector::kSift && grey.rows >= kHalvedFrom_px;
}

std::optional<Eigen::Matrix3d> PadFeatures::Find(const cv::Mat& grey, std::uint32_t seed) const {
  if (!Halves(grey)) return Match(Detect(grey, {detector_, ImageFeatures(detector_)}), seed);
  cv::Mat half;
  cv::resize(grey, half, {grey.cols / 2, grey.rows / 2}, 0, 0, cv::INTER_AREA);
  Features found = Detect(half, {detector_, ImageFeatures(detector_)});
  for (cv::KeyPoint& k : found.points) k.pt = 2 * k.pt + cv::Point2f(0.5F, 0.5F);
  return Match(found, seed);
}

std::optional<Eigen::Matrix3d> PadFeatures::FindSmall(const cv::Mat& grey, int rank,
                                                      std::uint32_t seed) const {
  if (!Halves(grey)) return std::nullopt;
  const cv::Rect part = PartOfMostContrast(grey, rank);
  cv::Mat bright;
  cv::normalize(grey(part), bright, 0, 255, cv::NORM_MINMAX);  // features have a least contrast
  Features found = Detect(bright, {detector_, ImageFeatures(detector_)});
  for (cv::KeyPoint& k : found.points) k.pt += cv::Point2f(part.tl());
  return Match(found, seed);
}

std::optional<Eigen::Matrix3d> PadFeatures::Match(const Features& found, std::uint32_t seed) const {
  // Of each feature the scale at which it looks most alike.
  struct Pair {
    float distance;
    Eigen::Vector2d place;
  };
  std::vector<std::optional<Pair>> best(found.points.size());
  for (const Scale& scale : *scales_) {
    for (const kestrel::vision::Match& match : MatchFeatures(found, scale.features, {})) {
      std::optional<Pair>& pair = best[match.a];
      if (!pair || match.distance < pair->distance) pair = {match.distance, scale.places[match.b]};
    }
  }
  std::vector<PointPair> pairs;
  for (std::size_t k = 0; k < best.size(); ++k) {
    const cv::Point2f& at = found.points[k].pt;
    if (best[k]) pairs.push_back({kMatched_px_per_m * best[k]->place, {at.x, at.y}});
  }
  const auto robust = RansacHomography(
      pairs, {.threshold = kThreshold_px, .max_trials = 2000, .min_inliers = kMinInliers}, seed);
  if (!robust) return std::nullopt;
  const Eigen::Matrix3d H_w =
      robust->H * Eigen::Vector3d(kMatched_px_per_m, kMatched_px_per_m, 1).asDiagonal();
  const auto X_CT = PoseFromHomography(H_w, camera_);
  // Round marks look alike mirrored too, and then agree on a pad that is seen from below.
  if (!X_CT || !(X_CT->R.toRotationMatrix().col(2).dot(X_CT->p) > 0)) return std::nullopt;
  return H_w;
}

}  // namespace kestrel::vision
