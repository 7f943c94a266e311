// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr int kMinTemplate_px = 80, kMaxTemplate_px = 450;  // shorter side of a template
constexpr int kMaxPixels = 20000;                           // of a template that are in view
constexpr double kFiner = 1.5;                              // of a template's pixels than the image's
constexpr int kInset_px = 2;                                // of a template, where the ground shows
constexpr int kLevels = 2;                                  // on coarser ones what hides the pad misleads
constexpr int kGrid = 27;                                   // points along either side
constexpr std::size_t kMaxPoints = 81;                      // of those in view, for the pose
constexpr double kMinAlignedInView = 0.05;                  // of the picture, which has marks at every scale
constexpr double kMinAlignedCorrelation = 0.8, kMinAgreeing = 0.4;
constexpr int kMaxBlurredPixels = 12000;  // of a template that is made anew for each image
constexpr int kMaxInstants = 16;          // of an exposure
constexpr std::array kExposures = {0.1, 0.25, 0.5, 0.75, 1.0};
constexpr double kMinBlurredSigma_grey = 8;  // of a blurred template: less could be any shading
constexpr double kMaxSurprise_px = 6;        // of a blurred pad's place, beside half the blur
constexpr double kBlurredSigma = 0.1;        // of its place, as a share of the blur

// Tukey's weights.
AlignmentOptions PadAlignmentOptions() {
  return {.loss = AlignmentLoss::kTukey,
          .levels = kLevels,
          .min_in_view = kMinAlignedInView,
          .min_correlation = kMinAlignedCorrelation};
}

// How far the outline of a picture moves between two homographies, px.
double Moved_px(const Eigen::Matrix3d& H_a, const Eigen::Matrix3d& H_b,
                const std::vector<Eigen::Vector2d>& points) {
  double moved = 0;
  for (const Eigen::Vector2d& p : points)
    moved = std::max(moved, (Transfer(H_a, p) - Transfer(H_b, p)).norm());
  return moved;
}

// The picture as it is seen at H(0), blurred by the motion H(s) = H + s H_step, |s| <= exposure / 2.
cv::Mat Blurred(const cv::Mat& picture, const Eigen::Matrix3d& pixel_from_T, const Eigen::Matrix3d& H,
                const Eigen::Matrix3d& H_step, double exposure, int instants) {
  cv::Mat sum(picture.size(), CV_32FC1, cv::Scalar(0)), seen;
  for (int i = 0; i < instants; ++i) {
    const double s = exposure * ((i + 0.5) / instants - 0.5);
    cv::Mat source;
    cv::eigen2cv(Eigen::Matrix3d(pixel_from_T * (H + s * H_step).inverse() * H * pixel_from_T.inverse()),
                 source);
    cv::warpPerspective(picture, seen, source, picture.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                        cv::BORDER_REPLICATE);
    cv::accumulate(seen, sum);
  }
  return sum / instants;
}

}  // namespace

PadAlignment::PadAlignment(const PadReference& reference, const Pinhole& camera,
                           const PadTrackerOptions& options)
    : camera_(camera), options_(options) {
  for (std::size_t i = 0; i < reference.levels.size(); i += PadReference::kLevelsOfOctave) {
    const PadReference::Level& level = reference.levels[i];
    const int side = std::min(level.image.cols, level.image.rows);
    if (side > kMaxTemplate_px || (side < kMinTemplate_px && !templates_.empty())) continue;
    const cv::Rect region(kInset_px, kInset_px, level.image.cols - 2 * kInset_px,
                          level.image.rows - 2 * kInset_px);
    templates_.push_back({level.image, region, {}, level.pixel_from_T, level.px_per_m});
  }
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      const double x = (i + 0.5) / kGrid - 0.5, y = (j + 0.5) / kGrid - 0.5;
      grid_.push_back({x * reference.length_m, y * reference.width_m});
    }
  }
}

void PadAlignment::Look(const cv::Mat& grey) { FillPyramid(grey, image_); }

// The points of the grid that show in the image.
std::vector<Eigen::Vector2d> PadAlignment::InView(const Eigen::Matrix3d& H_w) const {
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector2d& p : grid_) {
    const Eigen::Vector3d q = H_w * p.homogeneous();
    if (!(q.z() * H_w(2, 2) > 0)) continue;
    const Eigen::Vector2d uv = q.hnormalized();
    if (uv.x() >= 0 && uv.y() >= 0 && uv.x() <= camera_.width_px - 1 && uv.y() <= camera_.height_px - 1)
      seen.push_back(p);
  }
  return seen;
}

PadAlignment::Template* PadAlignment::Choose(const Eigen::Matrix3d& H_predicted, double& px_per_m) {
  const std::vector<Eigen::Vector2d> expected = InView(H_predicted);
  if (expected.empty()) return nullptr;
  const double share = static_cast<double>(expected.size()) / static_cast<double>(grid_.size());
  px_per_m = std::sqrt(std::abs(PlaceDerivative(H_predicted, expected[expected.size() / 2]).determinant()));
  const auto fits = [&](const Template& t) {
    return t.px_per_m < kFiner * px_per_m && share * t.region.area() < kMaxPixels;
  };
  const auto finest = std::find_if(templates_.begin(), templates_.end(), fits);
  return finest == templates_.end() ? &templates_.back() : &*finest;
}

std::optional<PadObservation> PadAlignment::Follow(const Eigen::Matrix3d& H_predicted) {
  points_.clear();
  double px_per_m = 0;
  Template* const chosen = Choose(H_predicted, px_per_m);
  if (!chosen) return std::nullopt;
  if (!chosen->aligner) chosen->aligner.emplace(chosen->picture, chosen->region, PadAlignmentOptions());
  return Observe(chosen->aligner->Align(image_, H_predicted * chosen->pixel_from_T.inverse()), *chosen,
                 px_per_m, 0);
}

std::optional<PadObservation> PadAlignment::FollowBlurred(const Eigen::Matrix3d& H_predicted,
                                                          const Eigen::Matrix3d& H_last) {
  points_.clear();
  double px_per_m = 0;
  const Template* chosen = Choose(H_predicted, px_per_m);
  if (!chosen) return std::nullopt;
  while (chosen->region.area() > kMaxBlurredPixels && chosen != &templates_.back()) ++chosen;
  const std::vector<Eigen::Vector2d> seen = InView(H_predicted);
  const double moved_image_px = Moved_px(H_predicted, H_last, seen),
               moved_px = moved_image_px * chosen->px_per_m / px_per_m;  // of the template

  const Eigen::Matrix3d W_predicted = H_predicted * chosen->pixel_from_T.inverse();

  struct Best {
    Alignment found;
    double exposure;
  };
  std::optional<Best> best;
  const auto align = [&](double exposure) {
    const double blur_px = std::min(exposure * moved_px, 1e3);
    const int instants = std::clamp(static_cast<int>(std::ceil(blur_px)), 2, kMaxInstants);
    const cv::Mat blurred =
        Blurred(chosen->picture, chosen->pixel_from_T, H_predicted, H_predicted - H_last, exposure, instants);
    // The ground gets into the rim.
    const int inset = std::clamp(static_cast<int>(std::ceil(blur_px / 2)), kInset_px,
                                 std::min(blurred.cols, blurred.rows) / 5);
    const cv::Rect region(inset, inset, blurred.cols - 2 * inset, blurred.rows - 2 * inset);
    cv::Scalar mean, sigma;
    cv::meanStdDev(blurred(region), mean, sigma);
    if (!(sigma[0] > kMinBlurredSigma_grey)) return;
    const Alignment found = Aligner(blurred, region, PadAlignmentOptions()).Align(image_, W_predicted);
    const double surprise_px = Moved_px(found.W * chosen->pixel_from_T, H_predicted, seen);
    if (found.state != AlignmentState::kConverged ||
        (best && !(found.correlation > best->found.correlation)) ||
        !(surprise_px < kMaxSurprise_px + exposure * moved_image_px / 2))
      return;
    best = {found, exposure};
  };
  if (exposure_ > 0) align(exposure_);
  if (!best)
    for (const double exposure : kExposures) align(exposure);
  if (!best) return std::nullopt;
  const auto observed =
      Observe(best->found, *chosen, px_per_m, kBlurredSigma * best->exposure * moved_image_px);
  if (observed) exposure_ = best->exposure;
  return observed;
}

std::optional<PadObservation> PadAlignment::Observe(const Alignment& found, const Template& chosen,
                                                    double px_per_m, double min_sigma_px) {
  if (found.state != AlignmentState::kConverged || !(found.agreeing >= kMinAgreeing)) return std::nullopt;
  const Eigen::Matrix3d H_w = found.W * chosen.pixel_from_T;
  const auto start = PoseFromHomography(H_w, camera_);
  if (!start) return std::nullopt;
  std::vector<PointPair> pairs;
  const std::vector<Eigen::Vector2d> seen_points = InView(H_w);
  const std::size_t every = (seen_points.size() + kMaxPoints - 1) / kMaxPoints;
  for (std::size_t i = 0; i < seen_points.size(); i += every)
    pairs.push_back({seen_points[i], Transfer(H_w, seen_points[i])});
  if (static_cast<int>(pairs.size()) < options_.min_inliers) return std::nullopt;
  // A template that is coarser than the image is aligned that much more coarsely. An alignment knows eight numbers,
  // and not two for each point of the grid.
  const double sigma_px =
      std::max(min_sigma_px, options_.sigma_px * std::max(1.0, px_per_m / chosen.px_per_m)) *
      std::max(1.0, std::sqrt(2.0 * static_cast<double>(pairs.size()) / 8));
  const auto pose = RefinePlanePose(pairs, camera_, *start, sigma_px);
  if (!pose || !(pose->rms_px < options_.threshold_px)) return std::nullopt;

  PadObservation seen;
  seen.X_CT = pose->X_CT;
  seen.covariance = pose->covariance;
  seen.H_w = HomographyFromPose(pose->X_CT, camera_);
  seen.inliers = static_cast<int>(pairs.size());
  seen.residual_px = pose->rms_px;
  seen.visible = found.in_view * found.agreeing;
  seen.registered = true;
  for (const PointPair& pair : pairs) points_.push_back(pair.to);
  return seen;
}

}  // namespace kestrel::vision
