// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_detector.h"
#include "vision/landmark/pad_features.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/tag_tracker.h"

namespace kestrel::vision {

struct PadTrackerOptions {
  bool registration = true;  // without it: as in the thesis
  int max_points = 90;
  int min_inliers = 10;
  double threshold_px = 1.5;
  double sigma_px = 0.08;
};

inline void Fields(FieldVisitor& v, PadTrackerOptions& o) {
  v({"registration",
     "register each image to the pad's known picture; false: chain homographies between images, which drift"},
    o.registration);
  v({"max_points", "approximate number of corners of the pad that are tracked in an image"}, o.max_points, 20,
    400);
  v({"min_inliers", "minimum number of points that must agree for the pad to count as seen"}, o.min_inliers,
    6, 100);
  v({"threshold_px", "maximum symmetric transfer distance of an inlier"}, o.threshold_px, 0.2, 10.0);
  v({"sigma_px", "standard deviation of a tracked point, from which the covariance of the pose follows"},
    o.sigma_px, 0.001, 5.0);
}

struct PadObservation {
  Pose X_CT;
  Eigen::Matrix<double, 6, 6> covariance;  // of (translation in C, m; rotation vector in C, rad)
  Eigen::Matrix3d H_w;                     // from T, m, to the image
  int inliers = 0;
  double residual_px = 0;  // root mean square of the inliers
  double visible = 0;      // area spanned by the inliers, as a share of the pad
  bool registered = false;
  bool found = false;  // by search in this frame, not by tracking
};

// The helipad from image to image, thesis 4.4: corners followed by pyramidal Lucas-Kanade from the last
// frame, a RANSAC homography (algorithm 1), the chain of 3.19 and 3.20, the pose of 3.22 to 3.25. The thesis
// names the drift of that chain as its weakness: here the chain is only the prediction, and the reference
// appearance, drawn as the prediction would see it, is registered to the frame, again by Lucas-Kanade and
// RANSAC. The pad is found anew by PadDetector when there is nothing to track.
//
// A pad of tags is searched in each image by TagTracker, and its picture registered only where no whole tag is
// in view. Of a pad that looks the same turned, such as an H, the direction is that of NearestTurn.
class PadTracker {
 public:
  PadTracker(PadReference reference, const Pinhole& camera, const PadTrackerOptions& options);

  // The pad in the next image (CV_8UC1). X_CT_expected: where it should be, from a filter, if known; it helps
  // over fast turns and short losses. None: the pad is lost in this image. There is never an old pose.
  std::optional<PadObservation> Track(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);

  // What the last Track() looked at, for the overlay: corners followed, and those that agreed, in pixels.
  const std::vector<Eigen::Vector2d>& tracked_points() const { return tracked_; }
  const std::vector<Eigen::Vector2d>& inlier_points() const { return agreed_; }
  const PadReference& reference() const { return reference_; }

 private:
  std::optional<Eigen::Matrix3d> Follow(const std::vector<cv::Mat>& pyramid,
                                        const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> Register(const cv::Mat& grey, const Eigen::Matrix3d& H_predicted);
  std::optional<PadObservation> Settle(const cv::Mat& grey, const Eigen::Matrix3d& H_guess, int passes);
  std::optional<PadObservation> Find(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> FindTags(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);
  std::optional<PadObservation> FromChain(const Eigen::Matrix3d& H_w) const;
  void Remember(const cv::Mat& grey, std::vector<cv::Mat> pyramid, const PadObservation& seen);
  void Forget();

  PadReference reference_;
  PadDetector detector_;
  std::optional<PadFeatures> features_;  // made when first needed
  std::optional<TagTracker> tags_;       // of a pad of tags
  Pinhole camera_;
  PadTrackerOptions options_;
  std::uint32_t frames_ = 0;

  // Memory of the last frame in which the pad was seen; an empty pyramid: none.
  std::vector<cv::Mat> last_pyramid_;
  std::vector<cv::Point2f> last_points_;
  Eigen::Matrix3d last_H_w_;
  int lost_frames_ = 0;
  int chain_inliers_ = 0;
  double chain_rms_px_ = 0;

  double gain_ = 1, offset_ = 0;  // grey of the image = gain * grey of the reference + offset
  bool exposure_known_ = false;
  std::vector<Eigen::Vector2d> tracked_, agreed_;
};

}  // namespace kestrel::vision
