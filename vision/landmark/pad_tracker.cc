// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <tuple>
#include <utility>

#include "vision/landmark/look_alike.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

const cv::Size kFollowWindow(15, 15);
constexpr int kFollowLevels = 3;
constexpr double kFollowThreshold_px = 2;
// A registration that moves the outline this far is done once more.
constexpr double kLargeCorrection_px = 0.5;
// That are enough where they go on from the last image, closely and mostly agreed: of a picture with few corners,
// or one that is mostly hidden.
constexpr int kFewInliers = 6;
// The dear search for a part of the pad is not made in every lost frame.
constexpr int kFramesBetweenFeatures = 3;
// Every other of these is for a pad that is small, in one of so many parts of the image after another.
constexpr int kPartsWithASmallPad = 3;
// Between two images, from which on its picture may be blurred beyond the corners' knowing it.
constexpr double kMinBlurringMotion_px = 5;
// Of 1,300 that were found blurred in two seeds of `kestrel bench planar` 12 had less.
constexpr double kMinBlurredLikeness = 0.25;
const cv::TermCriteria kLucasKanadeEnd(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);

cv::Point2f ToCv(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }
Eigen::Vector2d FromCv(const cv::Point2f& p) { return {p.x, p.y}; }

}  // namespace

PadTracker::PadTracker(PadReference reference, const Pinhole& camera, const PadTrackerOptions& options)
    : reference_(std::move(reference)),
      detector_(reference_, camera),
      camera_(camera),
      options_(options),
      registration_(camera, options) {
  if (!reference_.tags.empty()) tags_.emplace(reference_.tags, camera);
}

std::optional<PadObservation> PadTracker::Track(const cv::Mat& grey,
                                                const std::optional<Pose>& X_CT_expected) {
  ++frames_;
  tracked_.clear();
  agreed_.clear();
  corners_agreed_ = false;
  auto seen =
      options_.method == "icia" ? TrackPicture(grey, X_CT_expected) : TrackCorners(grey, X_CT_expected);
  X_CT_before_ = std::exchange(X_CT_last_, seen ? std::optional(seen->X_CT) : std::nullopt);
  return seen;
}

std::optional<PadObservation> PadTracker::TrackPicture(const cv::Mat& grey,
                                                       const std::optional<Pose>& X_CT_expected) {
  std::optional<PadObservation> seen;
  if (tags_) seen = FindTags(grey, X_CT_expected);
  const auto expected = X_CT_expected ? X_CT_expected : OfConstantVelocity();
  if (!seen && expected) seen = AlignmentTo(grey).Follow(HomographyFromPose(*expected, camera_));
  if (!seen && X_CT_last_) seen = AlignmentTo(grey).Follow(last_H_w_);
  if (!seen && expected) seen = FollowBlurred(grey, *expected);
  if (seen && tracked_.empty()) tracked_ = agreed_ = alignment_->points();
  if (!seen && !tags_) seen = Find(grey, X_CT_expected);
  if (seen) last_H_w_ = seen->H_w, lost_frames_ = 0;
  return seen;
}

std::optional<PadObservation> PadTracker::TrackCorners(const cv::Mat& grey,
                                                       const std::optional<Pose>& X_CT_expected) {
  std::optional<PadObservation> seen;
  if (tags_) seen = FindTags(grey, X_CT_expected);
  if (!seen && !options_.registration) {  // the thesis's chain
    if (const auto H_chain = Follow(grey, X_CT_expected)) seen = FromChain(*H_chain);
  } else if (!seen) {
    seen = FollowRegistered(grey, X_CT_expected);
  }
  if (!seen && !tags_) seen = Find(grey, X_CT_expected);
  if (seen) {
    Remember(grey, *seen);
  } else {
    Forget();
  }
  return seen;
}

// Mostly the pad is where it is expected, and most of its corners say so. Otherwise from the likeliest guess to the
// least: by the chain, by what is expected, blurred by its motion, by few corners, by the whole picture, by a chain
// that expects nothing.
std::optional<PadObservation> PadTracker::FollowRegistered(const cv::Mat& grey,
                                                           const std::optional<Pose>& X_CT_expected) {
  const auto expected = X_CT_expected ? X_CT_expected : OfConstantVelocity();
  std::optional<PadObservation> seen;
  if (expected && X_CT_last_) {
    seen = Settle(grey, HomographyFromPose(*expected, camera_), 2, options_.min_inliers, true);
    if (seen) return seen;
  }
  const auto H_chain = Follow(grey, expected);
  bool few_of_chain = false, few_of_expected = false;
  if (H_chain) {
    seen = Settle(grey, *H_chain, 2, options_.min_inliers);
    few_of_chain = alike_ >= kFewInliers;
  }
  if (!seen && expected) {
    seen = Settle(grey, HomographyFromPose(*expected, camera_), 3, options_.min_inliers);
    few_of_expected = alike_ >= kFewInliers;
  }
  // The few corners that are left of a blurred picture mislead.
  if (!seen || !fine_ || seen->inliers < kMostlyAgree * static_cast<double>(tracked_.size())) {
    const auto corners = std::make_tuple(tracked_, agreed_, corners_agreed_);
    std::optional<PadObservation> blurred;
    if (!seen || fine_) {
      if (H_chain) {
        if (const auto X_CT_chain = PoseFromHomography(*H_chain, camera_))
          blurred = FollowBlurred(grey, *X_CT_chain);
      }
      if (!blurred && expected) blurred = FollowBlurred(grey, *expected);
    }
    if (!blurred && seen) blurred = FollowBlurred(grey, seen->X_CT);
    if (blurred) {
      seen = blurred;
    } else {
      std::tie(tracked_, agreed_, corners_agreed_) = corners;
    }
  }
  if (!seen && few_of_chain) seen = Settle(grey, *H_chain, 2, kFewInliers);
  if (!seen && few_of_expected) seen = Settle(grey, HomographyFromPose(*expected, camera_), 2, kFewInliers);
  if (!seen && H_chain) seen = FollowPicture(grey, *H_chain);
  if (!seen && expected) seen = FollowPicture(grey, HomographyFromPose(*expected, camera_));
  if (!seen && expected && !X_CT_expected) {
    if (const auto H_still = Follow(grey, std::nullopt))
      seen = Settle(grey, *H_still, 2, options_.min_inliers);
  }
  return seen;
}

PadAlignment& PadTracker::AlignmentTo(const cv::Mat& grey) {
  if (!alignment_) alignment_.emplace(reference_, camera_, options_);
  if (std::exchange(aligned_frame_, frames_) != frames_) alignment_->Look(grey);
  return *alignment_;
}

// Where too few corners are seen: of a picture that has few, far away, or mostly hidden.
std::optional<PadObservation> PadTracker::FollowPicture(const cv::Mat& grey,
                                                        const Eigen::Matrix3d& H_predicted) {
  if (!X_CT_last_) return std::nullopt;
  auto seen = AlignmentTo(grey).Follow(H_predicted);
  if (seen) tracked_ = agreed_ = alignment_->points(), corners_agreed_ = false;
  return seen;
}

// As it went between the last two images.
std::optional<Pose> PadTracker::OfConstantVelocity() const {
  if (!X_CT_last_ || !X_CT_before_) return X_CT_last_;
  return *X_CT_last_ * X_CT_before_->Inverse() * *X_CT_last_;
}

// Since the last image, in which it was seen.
bool PadTracker::MovesFast(const Eigen::Matrix3d& H_w) const {
  const Eigen::Matrix3d H_last = HomographyFromPose(*X_CT_last_, camera_);
  double moved_px = 0;
  for (const Eigen::Vector2d& corner : reference_.Outline())
    moved_px = std::max(moved_px, (Transfer(H_w, corner) - Transfer(H_last, corner)).norm());
  return moved_px > kMinBlurringMotion_px;
}

// Where it moves far between two images.
std::optional<PadObservation> PadTracker::FollowBlurred(const cv::Mat& grey, const Pose& X_CT_expected) {
  if (!X_CT_last_) return std::nullopt;
  const Eigen::Matrix3d H_predicted = HomographyFromPose(X_CT_expected, camera_),
                        H_last = HomographyFromPose(*X_CT_last_, camera_);
  if (!MovesFast(H_predicted) || CoarseLikeness(grey, reference_, H_predicted) < kMinBlurredLikeness)
    return std::nullopt;
  auto seen = AlignmentTo(grey).FollowBlurred(H_predicted, H_last);
  if (seen) tracked_ = agreed_ = alignment_->points(), corners_agreed_ = false;
  return seen;
}

// A search without a guess.
std::optional<PadObservation> PadTracker::Find(const cv::Mat& grey,
                                               const std::optional<Pose>& X_CT_expected) {
  registration_.ForgetExposure();
  std::optional<PadObservation> seen;
  std::optional<Eigen::Matrix3d> H_expected;
  if (X_CT_expected) H_expected = HomographyFromPose(*X_CT_expected, camera_);
  const auto turned = [&](const Eigen::Matrix3d& H_w) {
    return NearestTurn(H_w, reference_.turns, H_expected);
  };
  const auto registered = [&](const Eigen::Matrix3d& H_w) {
    return options_.method == "icia" ? Align(grey, turned(H_w))
                                     : Settle(grey, turned(H_w), 3, options_.min_inliers);
  };
  // In the image in which the pad is lost, to follow it has taken its time, and features would take as much again. In
  // the very first image nothing has.
  const bool by_features = lost_frames_++ % kFramesBetweenFeatures == 1;
  if (!by_features || frames_ == 1)
    if (const auto H = detector_.Detect(grey)) seen = registered(*H);
  if (!seen && by_features) {
    if (!features_) features_.emplace(reference_, camera_, *FeatureDetectorNamed(options_.features));
    const int look = lost_frames_ / kFramesBetweenFeatures;
    if (const auto H = look % 2 == 0 ? features_->Find(grey, frames_)
                                     : features_->FindSmall(grey, look / 2 % kPartsWithASmallPad, frames_))
      seen = registered(*H);
  }
  if (seen && (LooksMirrored(grey, reference_, seen->H_w) || !RimAgrees(grey, reference_, seen->H_w)))
    return std::nullopt;
  if (seen) seen->found = true;
  return seen;
}

std::optional<PadObservation> PadTracker::FindTags(const cv::Mat& grey,
                                                   const std::optional<Pose>& X_CT_expected) {
  const auto tags = tags_->Track(grey, X_CT_expected);
  if (!tags) return std::nullopt;
  PadObservation seen;
  seen.X_CT = tags->pose.X_CT;
  seen.covariance = tags->pose.covariance;
  seen.H_w = HomographyFromPose(seen.X_CT, camera_);
  seen.inliers = static_cast<int>(tags->corners.size());
  seen.residual_px = tags->pose.rms_px;
  seen.found = !X_CT_last_;
  seen.registered = true;
  std::vector<cv::Point2f> spread, hull;
  for (const PointPair& pair : tags->corners) {
    spread.push_back(ToCv(pair.from));
    agreed_.push_back(pair.to);
  }
  tracked_ = agreed_;
  cv::convexHull(spread, hull);
  seen.visible = cv::contourArea(hull) / (reference_.length_m * reference_.width_m);
  return seen;
}

// Eq. (3.20): the homography of the last frame times the step to this one.
std::optional<Eigen::Matrix3d> PadTracker::Follow(const cv::Mat& grey,
                                                  const std::optional<Pose>& X_CT_expected) {
  if (last_grey_.empty() || last_points_.size() < 4) return std::nullopt;
  std::vector<cv::Point2f> points = last_points_;
  int flags = 0;
  if (X_CT_expected) {
    const Eigen::Matrix3d guess = HomographyFromPose(*X_CT_expected, camera_) * last_H_w_.inverse();
    for (cv::Point2f& p : points) p = ToCv(Transfer(guess, FromCv(p)));
    flags = cv::OPTFLOW_USE_INITIAL_FLOW;
  }
  if (std::exchange(flow_frame_, frames_) != frames_) {
    cv::buildOpticalFlowPyramid(last_grey_, last_pyramid_, kFollowWindow, kFollowLevels, true);
    cv::buildOpticalFlowPyramid(grey, pyramid_, kFollowWindow, kFollowLevels, false);
  }
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(last_pyramid_, pyramid_, last_points_, points, status, error, kFollowWindow,
                           kFollowLevels, kLucasKanadeEnd, flags, 1e-3);
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (status[i]) pairs.push_back({FromCv(last_points_[i]), FromCv(points[i])});
  }
  const int enough = options_.registration ? kFewInliers : options_.min_inliers;
  const auto step =
      RansacHomography(pairs, {.threshold = kFollowThreshold_px, .min_inliers = enough}, frames_);
  if (!step) return std::nullopt;
  chain_inliers_ = static_cast<int>(step->inliers.size());
  chain_rms_px_ = step->rms;
  if (!options_.registration) {
    for (const PointPair& pair : pairs) tracked_.push_back(pair.to);
    for (const int i : step->inliers) agreed_.push_back(pairs[i].to);
  }
  return step->H * last_H_w_;
}

std::optional<PadObservation> PadTracker::Align(const cv::Mat& grey, const Eigen::Matrix3d& H_guess) {
  auto seen = AlignmentTo(grey).Follow(H_guess);
  if (seen) tracked_ = agreed_ = alignment_->points();
  return seen;
}

// Registers until the correction is small, at most `passes` times.
std::optional<PadObservation> PadTracker::Settle(const cv::Mat& grey, const Eigen::Matrix3d& H_guess,
                                                 int passes, int min_inliers, bool plain) {
  Eigen::Matrix3d H = H_guess;
  std::optional<PadObservation> before;
  for (int pass = 1;; ++pass) {
    auto seen = Register(grey, H, min_inliers, plain);
    if (!seen) return before;
    if (pass >= passes) return seen;
    double moved = 0;
    for (const Eigen::Vector2d& corner : reference_.Outline()) {
      moved = std::max(moved, (Transfer(seen->H_w, corner) - Transfer(H_drawn_, corner)).norm());
    }
    if (moved < kLargeCorrection_px) return seen;
    H = seen->H_w;
    before = seen;
  }
}

std::optional<PadObservation> PadTracker::Register(const cv::Mat& grey, const Eigen::Matrix3d& H_predicted,
                                                   int min_inliers, bool plain) {
  Registered registered =
      plain ? registration_.RegisterPlain(reference_, grey, H_predicted, min_inliers, frames_)
            : registration_.Register(reference_, grey, H_predicted, min_inliers, frames_);
  // Of fewer corners than were asked for nothing is known.
  alike_ = registered.tracked.empty() ? min_inliers : registered.alike;
  if (registered.tracked.empty()) return std::nullopt;
  tracked_ = std::move(registered.tracked);
  agreed_ = std::move(registered.agreed);
  if (registered.seen) corners_agreed_ = true, fine_ = registered.coarser == 1, H_drawn_ = registered.H_drawn;
  return registered.seen;
}

std::optional<PadObservation> PadTracker::FromChain(const Eigen::Matrix3d& H_w) const {
  const auto X_CT = PoseFromHomography(H_w, camera_);
  if (!X_CT || VisiblePart(reference_, H_w, {camera_.width_px, camera_.height_px}).empty())
    return std::nullopt;
  PadObservation seen;
  seen.X_CT = *X_CT;
  seen.H_w = H_w;
  seen.inliers = chain_inliers_;
  seen.residual_px = chain_rms_px_;
  // A chain has no error of its own to measure: this is that of its last link.
  const double sigma = chain_rms_px_ / std::sqrt(std::max(chain_inliers_, 1));
  const double angle = sigma / (camera_.fx * 0.1);
  seen.covariance.setZero();
  seen.covariance.diagonal() << Eigen::Vector3d::Constant(std::pow(X_CT->p.z() * sigma / camera_.fx, 2)),
      Eigen::Vector3d::Constant(angle * angle);
  return seen;
}

void PadTracker::Remember(const cv::Mat& grey, const PadObservation& seen) {
  lost_frames_ = 0;
  if (!corners_agreed_) registration_.ForgetExposure();
  grey.copyTo(last_grey_);
  last_H_w_ = seen.H_w;
  last_points_.clear();
  if (corners_agreed_) {
    for (const Eigen::Vector2d& p : agreed_) last_points_.push_back(ToCv(p));
    return;
  }
  // As in the thesis: good features to track on the pad's place in this image. The corners of tags are too few,
  // and of an alignment there are none.
  const std::vector<cv::Point2f> visible = VisiblePart(reference_, seen.H_w, grey.size());
  std::vector<cv::Point> polygon;
  for (const cv::Point2f& p : visible) polygon.emplace_back(cvRound(p.x), cvRound(p.y));
  if (polygon.empty()) return;
  const cv::Rect box = cv::boundingRect(polygon) & cv::Rect({0, 0}, grey.size());
  for (cv::Point& p : polygon) p -= box.tl();
  cv::Mat mask(box.size(), CV_8UC1, cv::Scalar(0));
  cv::fillConvexPoly(mask, polygon, 255);
  cv::goodFeaturesToTrack(grey(box), last_points_, options_.max_points, 0.02, 5, mask, 3);
  for (cv::Point2f& p : last_points_) p += cv::Point2f(static_cast<float>(box.x), static_cast<float>(box.y));
}

void PadTracker::Forget() {
  last_grey_.release();
  last_points_.clear();
  registration_.ForgetExposure();
}

}  // namespace kestrel::vision
