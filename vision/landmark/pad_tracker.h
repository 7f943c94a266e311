// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_alignment.h"
#include "vision/landmark/pad_detector.h"
#include "vision/landmark/pad_features.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/pad_registration.h"
#include "vision/landmark/pad_tracking.h"
#include "vision/landmark/tag_tracker.h"

namespace kestrel::vision {

// The helipad from image to image, thesis 4.4: corners followed by pyramidal Lucas-Kanade from the last
// frame, a RANSAC homography (algorithm 1), the chain of 3.19 and 3.20, the pose of 3.22 to 3.25. The thesis
// names the drift of that chain as its weakness: here the reference appearance, drawn as it is expected to be seen,
// is registered to the frame, again by Lucas-Kanade and RANSAC; the chain predicts only where that fails. By the method
// icia, PadAlignment takes the place of both; it also follows, by either method, a pad that moves so fast that its
// picture is blurred. Where there is nothing to track the pad is found anew by PadDetector, and in each third image, but
// not in that in which it was lost, by PadFeatures.
//
// A pad of tags is searched in each image by TagTracker, and its picture registered only where no whole tag is
// in view. Of a pad that looks the same turned, such as an H, the direction is that of NearestTurn.
class PadTracker {
 public:
  PadTracker(PadReference reference, const Pinhole& camera, const PadTrackerOptions& options);

  // The pad in the next image (CV_8UC1). X_CT_expected: where it should be, from a filter, if known; it helps
  // over fast turns and short losses. Where it is not known the pad goes on as it went between the last two
  // images. None: the pad is lost in this image. There is never an old pose.
  std::optional<PadObservation> Track(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);

  // What the last Track() looked at, for the overlay: corners followed, and those that agreed, in pixels.
  const std::vector<Eigen::Vector2d>& tracked_points() const { return tracked_; }
  const std::vector<Eigen::Vector2d>& inlier_points() const { return agreed_; }
  const PadReference& reference() const { return reference_; }

 private:
  std::optional<PadObservation> TrackCorners(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> TrackPicture(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> FollowRegistered(const cv::Mat& grey,
                                                 const std::optional<Pose>& X_CT_expected);
  std::optional<Pose> OfConstantVelocity() const;
  std::optional<Eigen::Matrix3d> Follow(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  PadAlignment& AlignmentTo(const cv::Mat& grey);
  std::optional<PadObservation> FollowPicture(const cv::Mat& grey, const Eigen::Matrix3d& H_predicted);
  bool MovesFast(const Eigen::Matrix3d& H_w) const;
  std::optional<PadObservation> FollowBlurred(const cv::Mat& grey, const Pose& X_CT_expected);
  std::optional<PadObservation> Register(const cv::Mat& grey, const Eigen::Matrix3d& H_predicted,
                                         int min_inliers, bool plain);
  std::optional<PadObservation> Settle(const cv::Mat& grey, const Eigen::Matrix3d& H_guess, int passes,
                                       int min_inliers, bool plain = false);
  std::optional<PadObservation> Align(const cv::Mat& grey, const Eigen::Matrix3d& H_guess);
  std::optional<PadObservation> Find(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> FindTags(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> FromChain(const Eigen::Matrix3d& H_w) const;
  void Remember(const cv::Mat& grey, const PadObservation& seen);
  void Forget();

  PadReference reference_;
  PadDetector detector_;
  std::optional<PadFeatures> features_;    // made when first needed
  std::optional<PadAlignment> alignment_;  // made when first needed
  std::optional<TagTracker> tags_;         // of a pad of tags
  Pinhole camera_;
  PadTrackerOptions options_;
  std::uint32_t frames_ = 0, aligned_frame_ = 0;  // of all images, and that which alignment_ looks at
  std::uint32_t flow_frame_ = 0;                  // that of pyramid_
  std::vector<cv::Mat> pyramid_, last_pyramid_;   // for optical flow from last_grey_

  // Memory of the last frame in which the pad was seen; an empty image: none.
  cv::Mat last_grey_;
  std::vector<cv::Point2f> last_points_;
  Eigen::Matrix3d last_H_w_;
  std::optional<Pose> X_CT_last_, X_CT_before_;  // in the last frame, and in that before it
  int lost_frames_ = 1;                          // as in the image after that of a loss
  int chain_inliers_ = 0;
  double chain_rms_px_ = 0;

  PadRegistration registration_;
  std::vector<Eigen::Vector2d> tracked_, agreed_;
  bool corners_agreed_ = false;  // agreed_ are corners of the reference
  bool fine_ = true;             // those were found in the image as it is, not in one that is coarser
  int alike_ = 0;                // of the last that were registered, see Registered
  Eigen::Matrix3d H_drawn_;      // by which the reference was drawn for them
};

}  // namespace kestrel::vision
