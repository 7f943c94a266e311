// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vision/landmark/homography.h"
#include "vision/landmark/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr int kMinTemplate_px = 80, kMaxTemplate_px = 450;  // shorter side of a template
constexpr int kMaxPixels = 20000;                           // of a template that are in view
constexpr double kFiner = 1.5;                              // of a template's pixels than the image's
constexpr int kInset_px = 2;                                // of a template, where the ground shows
constexpr int kLevels = 2;                                  // on coarser ones what hides the pad misleads
constexpr int kGrid = 9;                                    // points along either side
constexpr double kMinAlignedCorrelation = 0.8, kMinAgreeing = 0.4;

}  // namespace

PadAlignment::PadAlignment(const PadReference& reference, const Pinhole& camera,
                           const PadTrackerOptions& options)
    : camera_(camera), options_(options) {
  for (const PadReference::Level& level : reference.levels) {
    const int side = std::min(level.image.cols, level.image.rows);
    const bool only = templates_.empty() && &level == &reference.levels.back();
    if ((side < kMinTemplate_px || side > kMaxTemplate_px) && !only) continue;
    const cv::Rect region(kInset_px, kInset_px, level.image.cols - 2 * kInset_px,
                          level.image.rows - 2 * kInset_px);
    const AlignmentOptions how{
        .loss = AlignmentLoss::kTukey, .levels = kLevels, .min_correlation = kMinAlignedCorrelation};
    templates_.push_back(
        {Aligner(level.image, region, how), level.pixel_from_T, level.px_per_m, 1.0 * region.area()});
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

std::optional<PadObservation> PadAlignment::Follow(const Eigen::Matrix3d& H_predicted) {
  points_.clear();
  const std::vector<Eigen::Vector2d> expected = InView(H_predicted);
  if (expected.empty()) return std::nullopt;
  const double share = static_cast<double>(expected.size()) / static_cast<double>(grid_.size());
  const double px_per_m =
      std::sqrt(std::abs(PlaceDerivative(H_predicted, expected[expected.size() / 2]).determinant()));
  const auto fits = [&](const Template& t) {
    return t.px_per_m < kFiner * px_per_m && share * t.pixels < kMaxPixels;
  };
  const auto finest = std::find_if(templates_.begin(), templates_.end(), fits);
  Template& chosen = finest == templates_.end() ? templates_.back() : *finest;

  const Alignment a = chosen.aligner.Align(image_, H_predicted * chosen.pixel_from_T.inverse());
  if (a.state != AlignmentState::kConverged || !(a.agreeing >= kMinAgreeing)) return std::nullopt;
  const Eigen::Matrix3d H_w = a.W * chosen.pixel_from_T;
  const auto start = PoseFromHomography(H_w, camera_);
  if (!start) return std::nullopt;
  std::vector<PointPair> pairs;
  for (const Eigen::Vector2d& p : InView(H_w)) pairs.push_back({p, Transfer(H_w, p)});
  if (static_cast<int>(pairs.size()) < options_.min_inliers) return std::nullopt;
  // A template that is coarser than the image is aligned that much more coarsely.
  const double sigma_px = options_.sigma_px * std::max(1.0, px_per_m / chosen.px_per_m);
  const auto pose = RefinePlanePose(pairs, camera_, *start, sigma_px);
  if (!pose || !(pose->rms_px < options_.threshold_px)) return std::nullopt;

  PadObservation seen;
  seen.X_CT = pose->X_CT;
  seen.covariance = pose->covariance;
  seen.H_w = HomographyFromPose(pose->X_CT, camera_);
  seen.inliers = static_cast<int>(pairs.size());
  seen.residual_px = pose->rms_px;
  seen.visible = a.in_view * a.agreeing;
  seen.registered = true;
  for (const PointPair& pair : pairs) points_.push_back(pair.to);
  return seen;
}

}  // namespace kestrel::vision
