// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "vision/landmark/homography.h"
#include "vision/landmark/look_alike.h"
#include "vision/landmark/plane_pose.h"

namespace kestrel::vision {
namespace {

const cv::Size kFollowWindow(15, 15);
constexpr int kFollowLevels = 3;
constexpr int kRegisterLevels = 2;
constexpr double kFollowThreshold_px = 2;
constexpr double kMinVisibleArea_px2 = 300;
// Correlation of a patch with the reference from which on the point counts.
constexpr double kMinCorrelation = 0.7;
// A registration that moves the outline this far is done once more.
constexpr double kLargeCorrection_px = 1.5;
// That are enough where they go on from the last image, closely and mostly agreed: of a picture with few corners,
// or one that is mostly hidden.
constexpr int kFewInliers = 6;
constexpr double kFewThreshold_px = 0.5;
constexpr double kMostlyAgree = 0.6;  // of the corners that are tracked
// The dear search for a part of the pad is not made in every lost frame.
constexpr int kFramesBetweenFeatures = 3;
// Between two images, from which on its picture may be blurred beyond the corners' knowing it.
constexpr double kMinBlurringMotion_px = 5;
const cv::TermCriteria kLucasKanadeEnd(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);

cv::Point2f ToCv(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }
Eigen::Vector2d FromCv(const cv::Point2f& p) { return {p.x, p.y}; }

// The part of the pad that lies in the image, as a convex polygon; empty where there is none.
std::vector<cv::Point2f> VisiblePart(const PadReference& reference, const Eigen::Matrix3d& H_w,
                                     const cv::Size& size) {
  std::vector<cv::Point2f> outline, visible;
  const double side = (H_w.row(2) * Eigen::Vector3d(0, 0, 1))(0);
  for (const Eigen::Vector2d& corner : reference.Outline()) {
    // A corner behind the camera: the pad cannot be seen as a polygon.
    if (!((H_w.row(2) * corner.homogeneous())(0) * side > 0)) return {};
    outline.push_back(ToCv(Transfer(H_w, corner)));
  }
  const float w = static_cast<float>(size.width - 1), h = static_cast<float>(size.height - 1);
  const std::vector<cv::Point2f> image = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  if (!(cv::intersectConvexConvex(outline, image, visible) > kMinVisibleArea_px2)) return {};
  return visible;
}

// Pixels per metre of the plane, from the area of a polygon in the image and of its preimage on the pad.
double ScaleOf(const std::vector<cv::Point2f>& visible, const Eigen::Matrix3d& H_w) {
  const Eigen::Matrix3d H_inverse = H_w.inverse();
  std::vector<cv::Point2f> on_pad;
  for (const cv::Point2f& p : visible) on_pad.push_back(ToCv(Transfer(H_inverse, FromCv(p))));
  return std::sqrt(cv::contourArea(visible) / std::max(cv::contourArea(on_pad), 1e-9));
}

// Zero-mean normalised correlation of two square patches.
double Correlation(const cv::Mat& a, const cv::Point2f& at_a, const cv::Mat& b, const cv::Point2f& at_b) {
  constexpr int kSide = 11;
  cv::Mat patch_a, patch_b;
  cv::getRectSubPix(a, {kSide, kSide}, at_a, patch_a);
  cv::getRectSubPix(b, {kSide, kSide}, at_b, patch_b);
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int y = 0; y < kSide; ++y) {
    const uchar *ra = patch_a.ptr(y), *rb = patch_b.ptr(y);
    for (int x = 0; x < kSide; ++x) {
      const double va = ra[x], vb = rb[x];
      sa += va, sb += vb, saa += va * va, sbb += vb * vb, sab += va * vb;
    }
  }
  const double n = kSide * kSide;
  const double variance = (saa - sa * sa / n) * (sbb - sb * sb / n);
  return variance > 0 ? (sab - sa * sb / n) / std::sqrt(variance) : 0;
}

}  // namespace

PadTracker::PadTracker(PadReference reference, const Pinhole& camera, const PadTrackerOptions& options)
    : reference_(std::move(reference)), detector_(reference_, camera), camera_(camera), options_(options) {
  if (options.method == "icia") alignment_.emplace(reference_, camera, options);
  if (!reference_.tags.empty()) tags_.emplace(reference_.tags, camera);
}

std::optional<PadObservation> PadTracker::Track(const cv::Mat& grey,
                                                const std::optional<Pose>& X_CT_expected) {
  ++frames_;
  tracked_.clear();
  agreed_.clear();
  corners_agreed_ = false;
  const auto seen =
      options_.method == "icia" ? TrackPicture(grey, X_CT_expected) : TrackCorners(grey, X_CT_expected);
  X_CT_before_ = std::exchange(X_CT_last_, seen ? std::optional(seen->X_CT) : std::nullopt);
  return seen;
}

std::optional<PadObservation> PadTracker::TrackPicture(const cv::Mat& grey,
                                                       const std::optional<Pose>& X_CT_expected) {
  std::optional<PadObservation> seen;
  if (tags_) seen = FindTags(grey, X_CT_expected);
  const auto expected = X_CT_expected ? X_CT_expected : OfConstantVelocity();
  if (!seen && expected) alignment_->Look(grey);
  if (!seen && expected) seen = alignment_->Follow(HomographyFromPose(*expected, camera_));
  if (!seen && X_CT_last_) seen = alignment_->Follow(last_H_w_);
  if (!seen && expected) seen = FollowBlurred(grey, *expected);
  if (seen && tracked_.empty()) tracked_ = agreed_ = alignment_->points();
  if (!seen && !tags_) seen = Find(grey, X_CT_expected);
  if (seen) last_H_w_ = seen->H_w, lost_frames_ = 0;
  return seen;
}

std::optional<PadObservation> PadTracker::TrackCorners(const cv::Mat& grey,
                                                       const std::optional<Pose>& X_CT_expected) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(grey, pyramid, kFollowWindow, kFollowLevels, true);

  std::optional<PadObservation> seen;
  if (tags_) seen = FindTags(grey, X_CT_expected);
  if (!seen && !options_.registration) {  // the thesis's chain
    if (const auto H_chain = Follow(pyramid, X_CT_expected)) seen = FromChain(*H_chain);
  } else if (!seen) {
    seen = FollowRegistered(grey, pyramid, X_CT_expected);
  }
  if (!seen && !tags_) seen = Find(grey, X_CT_expected);
  if (seen) {
    Remember(grey, std::move(pyramid), *seen);
  } else {
    Forget();
  }
  return seen;
}

// From the likeliest guess to the least: by the chain, by what is expected, blurred by its motion, by few corners, by
// the whole picture, by a chain that expects nothing.
std::optional<PadObservation> PadTracker::FollowRegistered(const cv::Mat& grey,
                                                           const std::vector<cv::Mat>& pyramid,
                                                           const std::optional<Pose>& X_CT_expected) {
  const auto expected = X_CT_expected ? X_CT_expected : OfConstantVelocity();
  const auto H_chain = Follow(pyramid, expected);
  std::optional<PadObservation> seen;
  if (H_chain) seen = Settle(grey, *H_chain, 2, options_.min_inliers);
  if (!seen && expected) seen = Settle(grey, HomographyFromPose(*expected, camera_), 3, options_.min_inliers);
  // The few corners that are left of a blurred picture mislead.
  if (!seen || seen->inliers < kMostlyAgree * static_cast<double>(tracked_.size())) {
    const auto corners = std::make_tuple(tracked_, agreed_, corners_agreed_);
    std::optional<PadObservation> blurred;
    if (H_chain) {
      if (const auto X_CT_chain = PoseFromHomography(*H_chain, camera_))
        blurred = FollowBlurred(grey, *X_CT_chain);
    }
    if (!blurred && expected) blurred = FollowBlurred(grey, *expected);
    if (!blurred && seen) blurred = FollowBlurred(grey, seen->X_CT);
    if (blurred) {
      seen = blurred;
    } else {
      std::tie(tracked_, agreed_, corners_agreed_) = corners;
    }
  }
  if (!seen && H_chain) seen = Settle(grey, *H_chain, 2, kFewInliers);
  if (!seen && expected) seen = Settle(grey, HomographyFromPose(*expected, camera_), 2, kFewInliers);
  if (!seen && H_chain) seen = FollowPicture(grey, *H_chain);
  if (!seen && expected) seen = FollowPicture(grey, HomographyFromPose(*expected, camera_));
  if (!seen && expected && !X_CT_expected) {
    if (const auto H_still = Follow(pyramid, std::nullopt))
      seen = Settle(grey, *H_still, 2, options_.min_inliers);
  }
  return seen;
}

// Where too few corners are seen: of a picture that has few, far away, or mostly hidden.
std::optional<PadObservation> PadTracker::FollowPicture(const cv::Mat& grey,
                                                        const Eigen::Matrix3d& H_predicted) {
  if (!X_CT_last_) return std::nullopt;
  if (!alignment_) alignment_.emplace(reference_, camera_, options_);
  alignment_->Look(grey);
  const auto seen = alignment_->Follow(H_predicted);
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
  if (!MovesFast(H_predicted)) return std::nullopt;
  if (!alignment_) alignment_.emplace(reference_, camera_, options_);
  alignment_->Look(grey);
  const auto seen = alignment_->FollowBlurred(H_predicted, H_last);
  if (seen) tracked_ = agreed_ = alignment_->points(), corners_agreed_ = false;
  return seen;
}

// A search without a guess.
std::optional<PadObservation> PadTracker::Find(const cv::Mat& grey,
                                               const std::optional<Pose>& X_CT_expected) {
  exposure_known_ = false;
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
  if (const auto H = detector_.Detect(grey)) seen = registered(*H);
  if (!seen && lost_frames_++ % kFramesBetweenFeatures == 0) {
    if (!features_) features_.emplace(reference_, camera_, *FeatureDetectorNamed(options_.features));
    if (const auto H = features_->Find(grey, frames_)) seen = registered(*H);
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
std::optional<Eigen::Matrix3d> PadTracker::Follow(const std::vector<cv::Mat>& pyramid,
                                                  const std::optional<Pose>& X_CT_expected) {
  if (last_pyramid_.empty() || last_points_.size() < 4) return std::nullopt;
  std::vector<cv::Point2f> points = last_points_;
  int flags = 0;
  if (X_CT_expected) {
    const Eigen::Matrix3d guess = HomographyFromPose(*X_CT_expected, camera_) * last_H_w_.inverse();
    for (cv::Point2f& p : points) p = ToCv(Transfer(guess, FromCv(p)));
    flags = cv::OPTFLOW_USE_INITIAL_FLOW;
  }
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(last_pyramid_, pyramid, last_points_, points, status, error, kFollowWindow,
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
  alignment_->Look(grey);
  auto seen = alignment_->Follow(H_guess);
  if (seen) tracked_ = agreed_ = alignment_->points();
  return seen;
}

// Registers until the correction is small, at most `passes` times.
std::optional<PadObservation> PadTracker::Settle(const cv::Mat& grey, const Eigen::Matrix3d& H_guess,
                                                 int passes, int min_inliers) {
  Eigen::Matrix3d H = H_guess;
  std::optional<PadObservation> before;
  for (int pass = 1;; ++pass) {
    const auto seen = Register(grey, H, min_inliers);
    if (!seen) return before;
    if (pass >= passes) return seen;
    double moved = 0;
    for (const Eigen::Vector2d& corner : reference_.Outline()) {
      moved = std::max(moved, (Transfer(seen->H_w, corner) - Transfer(H, corner)).norm());
    }
    if (moved < kLargeCorrection_px) return seen;
    H = seen->H_w;
    before = seen;
  }
}

// Draws the reference as the camera would see it under H_predicted, in the exposure of the last frame, and
// finds its corners in the image.
std::optional<PadObservation> PadTracker::Register(const cv::Mat& grey, const Eigen::Matrix3d& H_predicted,
                                                   int min_inliers) {
  const std::vector<cv::Point2f> visible = VisiblePart(reference_, H_predicted, grey.size());
  if (visible.empty()) return std::nullopt;
  const double px_per_m = ScaleOf(visible, H_predicted);
  const PadReference::Level& level = reference_.LevelFor(px_per_m);
  const int window = px_per_m * reference_.width_m < 120 ? 9 : 13;

  const int margin = 2 * window;
  cv::Rect box = cv::boundingRect(visible);
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect({0, 0}, grey.size());
  const cv::Mat seen_box = grey(box);

  std::vector<cv::Point> polygon;
  for (const cv::Point2f& p : visible) polygon.emplace_back(cvRound(p.x) - box.x, cvRound(p.y) - box.y);
  cv::Mat on_pad(box.size(), CV_8UC1, cv::Scalar(0));
  cv::fillConvexPoly(on_pad, polygon, 255);

  Eigen::Matrix3d to_box = Eigen::Matrix3d::Identity();
  to_box(0, 2) = -box.x, to_box(1, 2) = -box.y;
  cv::Mat map, drawn;
  cv::eigen2cv(Eigen::Matrix3d(to_box * H_predicted * level.pixel_from_T.inverse()), map);
  cv::warpPerspective(level.image, drawn, map, box.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  if (!exposure_known_) {
    cv::Scalar mean_drawn, mean_seen, sigma_drawn, sigma_seen;
    cv::meanStdDev(drawn, mean_drawn, sigma_drawn, on_pad);
    cv::meanStdDev(seen_box, mean_seen, sigma_seen, on_pad);
    gain_ = std::clamp(sigma_seen[0] / std::max(sigma_drawn[0], 1.0), 0.2, 5.0);
    offset_ = mean_seen[0] - gain_ * mean_drawn[0];
  }
  drawn.convertTo(drawn, -1, gain_, offset_);
  // What lies around the pad is not known: its mean grey makes the pad's own rim an honest edge.
  const cv::Scalar around = cv::mean(seen_box, ~on_pad);
  drawn.setTo(around, ~on_pad);

  // The strongest corners, spread over the visible part: one for each cell of a grid.
  const double cell = std::max(4.0, std::sqrt(cv::contourArea(visible) / options_.max_points));
  std::set<std::pair<int, int>> taken;
  std::vector<Eigen::Vector2d> corners_T;
  std::vector<cv::Point2f> from, to;
  const double inset = 3;
  for (const Eigen::Vector2d& corner : level.corners) {
    const Eigen::Vector2d uv = Transfer(H_predicted, corner);
    if (!(uv.x() > inset && uv.y() > inset && uv.x() < grey.cols - 1 - inset &&
          uv.y() < grey.rows - 1 - inset))
      continue;
    if (!taken.emplace(static_cast<int>(uv.x() / cell), static_cast<int>(uv.y() / cell)).second) continue;
    corners_T.push_back(corner);
    from.push_back(ToCv(uv) - cv::Point2f(static_cast<float>(box.x), static_cast<float>(box.y)));
    if (static_cast<int>(from.size()) >= 2 * options_.max_points) break;
  }
  if (static_cast<int>(from.size()) < min_inliers) return std::nullopt;
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(drawn, seen_box, from, to, status, error, {window, window}, kRegisterLevels,
                           kLucasKanadeEnd, 0, 1e-3);

  std::vector<PointPair> pairs;    // drawn pixel to seen pixel
  std::vector<PointPair> pairs_T;  // pad to seen pixel
  std::vector<cv::Point2f> at_drawn;
  const cv::Point2f corner_of_box(static_cast<float>(box.x), static_cast<float>(box.y));
  std::vector<Eigen::Vector2d> tracked;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!status[i]) continue;
    tracked.push_back(FromCv(to[i] + corner_of_box));
    // Where something hides the pad, Lucas-Kanade converges too, but not onto the same picture.
    if (!(Correlation(drawn, from[i], seen_box, to[i]) > kMinCorrelation)) continue;
    pairs.push_back({FromCv(from[i]), FromCv(to[i])});
    pairs_T.push_back({corners_T[i], FromCv(to[i] + corner_of_box)});
    at_drawn.push_back(from[i]);
  }
  tracked_ = tracked;
  agreed_.clear();
  const auto robust =
      RansacHomography(pairs, {.threshold = options_.threshold_px, .min_inliers = min_inliers}, frames_);
  if (!robust) return std::nullopt;
  std::vector<PointPair> inliers;
  for (const int i : robust->inliers) inliers.push_back(pairs_T[i]);
  const auto H_w = FitHomography(inliers);
  if (!H_w) return std::nullopt;
  const auto start = PoseFromHomography(*H_w, camera_);
  if (!start) return std::nullopt;
  auto pose = RefinePlanePose(inliers, camera_, *start, options_.sigma_px);
  if (!pose || !(pose->rms_px < options_.threshold_px)) return std::nullopt;
  if (static_cast<int>(inliers.size()) < options_.min_inliers &&
      !(pose->rms_px < kFewThreshold_px && inliers.size() > kMostlyAgree * static_cast<double>(pairs.size())))
    return std::nullopt;
  pose->covariance += CovarianceOfShift(pose->X_CT, options_.shift_px / camera_.fx);

  PadObservation seen;
  seen.X_CT = pose->X_CT;
  seen.covariance = pose->covariance;
  seen.H_w = HomographyFromPose(pose->X_CT, camera_);
  seen.inliers = static_cast<int>(inliers.size());
  seen.residual_px = pose->rms_px;
  seen.registered = corners_agreed_ = true;
  std::vector<cv::Point2f> spread, hull;
  for (const PointPair& pair : inliers) {
    spread.push_back(ToCv(pair.from));
    agreed_.push_back(pair.to);
  }
  cv::convexHull(spread, hull);
  seen.visible = cv::contourArea(hull) / (reference_.length_m * reference_.width_m);

  // The exposure of this frame, for the next one: regression of grey on grey over the patches that agreed.
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const int i : robust->inliers) {
    cv::Mat a, b;
    cv::getRectSubPix(drawn, {7, 7}, at_drawn[i], a);
    cv::getRectSubPix(seen_box, {7, 7}, ToCv(pairs[i].to), b);
    for (int k = 0; k < 49; ++k) {
      const double x = a.data[k], y = b.data[k];
      n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
  }
  const double slope = (sxy - sx * sy / n) / std::max(sxx - sx * sx / n, 1e-9);
  if (slope > 0.5 && slope < 2) {
    // drawn = gain * reference + offset and seen = slope * drawn + shift: the two affine maps one after the
    // other
    offset_ = slope * offset_ + (sy - slope * sx) / n;
    gain_ = std::clamp(slope * gain_, 0.1, 10.0);
    exposure_known_ = true;
  }
  return seen;
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

void PadTracker::Remember(const cv::Mat& grey, std::vector<cv::Mat> pyramid, const PadObservation& seen) {
  lost_frames_ = 0;
  if (!corners_agreed_) exposure_known_ = false;
  last_pyramid_ = std::move(pyramid);
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
  last_pyramid_.clear();
  last_points_.clear();
  exposure_known_ = false;
}

}  // namespace kestrel::vision
