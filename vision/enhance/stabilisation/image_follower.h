// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/motion/image_motion.h"
#include "vision/enhance/stabilisation/stabilised_state.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"

namespace kestrel::vision {

// What is known of an image beside its pixels.
struct ImageAttitudes {
  // R_NC while the rows were exposed, at even times from the first row to the last; one: of all rows; empty: not
  // known. N is any frame that does not turn.
  std::vector<Eigen::Quaterniond> R_NC_rows;
  std::optional<Eigen::Vector3d> down_C;  // unit vector, at the middle row, as the skyline shows it
  double readout_s = 0;                   // from the first row to the last; negative: the last row is first
};

// How the camera went from the image before to this one: a rotation, and what remains as the motion of a plane.
struct FollowedImage {
  StabilisedState state = StabilisedState::kFirst;
  bool begins = true;                         // it has nothing to do with those before it
  std::vector<Eigen::Quaterniond> R_NC_rows;  // empty: images alone are followed, and N has the axes of C
  Eigen::Quaterniond R_NC = Eigen::Quaterniond::Identity();  // at the middle row
  // From the directions in N that the image before shows to those where this one shows the same; of images alone, a
  // direction is (u, v, 1).
  Eigen::Matrix3d G = Eigen::Matrix3d::Identity();
  std::optional<Eigen::Vector3d> down_N;
  int points = 0, inliers = 0;
  double rms_px = 0;
};

class ImageFollower {
 public:
  // camera: none, of images alone. virtual_camera: by == both, the pinhole whose images the plane's motion is of.
  // keyframes: an image is compared with a keyframe, not with that before it, so that errors do not add up: with the
  // first one that it shows most of, else with the last.
  ImageFollower(const StabiliserOptions& options, const std::optional<CameraModel>& camera,
                const Pinhole& virtual_camera, bool keyframes);

  FollowedImage Step(const cv::Mat& grey, double t_s, const ImageAttitudes& attitudes);
  // Makes the image of the last Step() the first keyframe.
  void Anchor();
  const std::vector<PointPair>& last_inliers() const { return inliers_; }

 private:
  struct Measured {  // as of FollowedImage, but from from_
    ImageMotion motion;
    Eigen::Matrix3d G = Eigen::Matrix3d::Identity();
    Eigen::Quaterniond R_NC = Eigen::Quaterniond::Identity();
  };
  struct Compared {  // what images are compared with
    MotionImage image;
    double t_s = 0, not_before_s = 0;  // not_before_s: it was tried in vain until then
    std::vector<Eigen::Quaterniond> R_NC_rows;
    Eigen::Quaterniond R_NC = Eigen::Quaterniond::Identity();
    // From what the first keyframe shows to what this one does, of directions in N and of pixels.
    Eigen::Matrix3d G = Eigen::Matrix3d::Identity(), H = Eigen::Matrix3d::Identity();
  };
  Measured Measure(MotionImage& now, double t_s, const FollowedImage& followed, double readout_s) const;
  Measured MeasureByKeyframes(MotionImage& now, double t_s, const FollowedImage& followed, double readout_s);
  void Begin(MotionImage now, double t_s, const FollowedImage& followed);
  void AddKeyframe();
  // The first of the keyframes before `until` that the last image shows most of; none: `until`.
  std::size_t Seen(std::size_t until, double t_s) const;
  void CompareWith(std::size_t keyframe);
  bool HalfAgree(std::size_t inliers) const;  // of the points of from_

  StabiliserOptions options_;
  std::optional<CameraModel> camera_;
  Pinhole virtual_;
  bool by_keyframes_, turned_;
  // What the next image is compared with, and how the last image came from it.
  mutable Compared from_;
  Compared last_;
  Eigen::Matrix3d G_last_ = Eigen::Matrix3d::Identity(), H_last_ = Eigen::Matrix3d::Identity();
  std::vector<Compared> keyframes_;
  std::size_t keyframe_ = 0;  // of which from_ is a copy
  std::vector<PointPair> inliers_;
  bool any_ = false, last_is_known_ = false;
};

}  // namespace kestrel::vision
