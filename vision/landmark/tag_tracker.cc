// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/tag_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace kestrel::vision {
namespace {

constexpr double kSigma_px = 0.15;  // of a corner; measured at tags of 4 px to a cell and more
constexpr double kMinMargin = 20;   // grey levels
constexpr double kAgrees_px =
    2;  // from where a tag's pose puts another's corner, and more for what is far off
constexpr double kAgreesShare = 0.1;  // of that distance
constexpr double kMaxRms_px = 2;
constexpr double kClearlyBetter = 2;  // of two residuals, the one over the other
constexpr int kForgetFrames = 15;

std::vector<PointPair> PairsOf(const Tag& tag, const DetectedTag& seen) {
  const auto corners_T = CornersOf(tag);
  std::vector<PointPair> pairs;
  for (std::size_t k = 0; k < 4; ++k) pairs.push_back({corners_T[k], seen.corners[k]});
  return pairs;
}

double SizeOf(const std::vector<PointPair>& pairs) { return (pairs[0].to - pairs[2].to).norm(); }

// Whether another tag lies where the pose by this one has it: the coarser the one, the less it says of far corners.
bool Agrees(const Eigen::Matrix3d& H_w, const std::vector<PointPair>& one,
            const std::vector<PointPair>& other) {
  const Eigen::Vector2d middle = (one[0].to + one[2].to) / 2;
  return std::all_of(other.begin(), other.end(), [&](const PointPair& pair) {
    const double off = (Transfer(H_w, pair.from) - pair.to).norm();
    return off < kAgrees_px + kAgreesShare * (pair.to - middle).norm();
  });
}

double Distance(const Pose& a, const Pose& b) { return (a.p - b.p).norm() + a.R.angularDistance(b.R); }

// A small square looks nearly the same tilted to the other side of the line of sight: of both poses the one that
// fits better, or where neither is clearly so, the one that is expected.
std::optional<PlanePose> LikelierPose(const std::vector<PointPair>& pairs, const Pinhole& camera,
                                      const Pose& X_CT_start, const std::optional<Pose>& near) {
  const auto one = RefinePlanePose(pairs, camera, X_CT_start, kSigma_px);
  const Pose& from = one ? one->X_CT : X_CT_start;
  const Eigen::AngleAxisd about_sight(M_PI, from.p.normalized()),
      about_normal(M_PI, Eigen::Vector3d::UnitZ());
  const Pose mirrored{Eigen::Quaterniond(about_sight * from.R * about_normal).normalized(), from.p};
  const auto other = RefinePlanePose(pairs, camera, mirrored, kSigma_px);
  if (!one || !other) return one ? one : other;
  const double a = std::max(one->rms_px, kSigma_px), b = std::max(other->rms_px, kSigma_px);
  if (near && std::max(a, b) < kClearlyBetter * std::min(a, b))
    return Distance(one->X_CT, *near) <= Distance(other->X_CT, *near) ? one : other;
  return a <= b ? one : other;
}

}  // namespace

TagTracker::TagTracker(std::vector<Tag> tags, const Pinhole& camera)
    : tags_(std::move(tags)), camera_(camera), detector_(tags_) {}

std::optional<TagsSeen> TagTracker::Track(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected) {
  struct Seen {
    std::size_t index;
    std::vector<PointPair> pairs;
    bool taken = false;  // by a larger one, whose pose says where it must be
  };
  std::vector<Seen> all;
  for (const DetectedTag& tag : detector_.Detect(grey))
    if (tag.margin > kMinMargin) all.push_back({tag.index, PairsOf(tags_[tag.index], tag)});
  std::stable_sort(all.begin(), all.end(),
                   [](const Seen& a, const Seen& b) { return SizeOf(a.pairs) > SizeOf(b.pairs); });

  const std::optional<Pose>& near = X_CT_expected ? X_CT_expected : X_CT_last_;
  std::optional<TagsSeen> best;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].taken) continue;
    const auto H_w = FitHomography(all[i].pairs);
    const auto start = H_w ? PoseFromHomography(*H_w, camera_) : std::nullopt;
    if (!start) continue;
    TagsSeen pad{.pose = {}, .corners = all[i].pairs, .tags = 1};
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (all[k].taken || all[k].index == all[i].index || !Agrees(*H_w, all[i].pairs, all[k].pairs)) continue;
      all[k].taken = true;
      pad.corners.insert(pad.corners.end(), all[k].pairs.begin(), all[k].pairs.end());
      ++pad.tags;
    }
    const auto pose = LikelierPose(pad.corners, camera_, *start, near);
    if (!pose || !(pose->rms_px < kMaxRms_px)) continue;
    pad.pose = *pose;
    // With nothing to go by, the one of which more is seen: the nearer.
    if (!best || (near && Distance(pose->X_CT, *near) < Distance(best->pose.X_CT, *near)))
      best = std::move(pad);
  }
  if (best) {
    X_CT_last_ = best->pose.X_CT;
    lost_frames_ = 0;
  } else if (++lost_frames_ > kForgetFrames) {
    X_CT_last_.reset();
  }
  return best;
}

}  // namespace kestrel::vision
