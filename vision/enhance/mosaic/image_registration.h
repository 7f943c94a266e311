// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/mosaic/motion_estimate.h"
#include "vision/enhance/motion/point_flow.h"
#include "vision/landmark/features/features.h"

namespace kestrel::vision {

// A panorama is what is seen from one place, its centre, and a camera that turns strays from there. Flat ground then
// shows a parallax that is known from the camera's pose: a ray r towards the ground, seen from the centre, is
// r + moved (down . r).
struct GroundParallax {
  // From the centre to the camera, over its height above the ground.
  Eigen::Vector3d moved_C = Eigen::Vector3d::Zero();
  Eigen::Vector3d down_C = Eigen::Vector3d::Zero();
};

// A grey image and what others are registered to it by, each made when it is first asked for.
class RegisteredImage {
 public:
  // opencl: what it is registered by is followed on a device of OpenCL, if there is one.
  RegisteredImage(cv::Mat grey, int max_corners, bool opencl = false)
      : grey_(std::move(grey)), max_corners_(max_corners), opencl_(opencl) {}

  const cv::Mat& grey() const { return grey_; }
  const std::vector<cv::Point2f>& corners();  // Shi and Tomasi 1994, spread over the image
  const FlowPyramid& pyramid();
  FlowOptions flow() const;                // of its pyramid
  const Features& features();              // ORB
  void ForgetPyramid();                    // the largest of them
  std::optional<GroundParallax> parallax;  // none: its places are taken as they are seen

 private:
  cv::Mat grey_;
  int max_corners_;
  bool opencl_;
  bool has_corners_ = false, has_features_ = false;
  std::vector<cv::Point2f> corners_;
  FlowPyramid pyramid_;
  Features features_;
};

// Places of a in b, by pyramidal Lucas-Kanade from where M_AB says that they are. Where b is turned or scaled
// against a, it is first drawn as a would see it. Without the parallax of either, as all pairs here.
std::vector<PixelPair> FollowedPairs(const CameraModel& camera, RegisteredImage& a, RegisteredImage& b,
                                     const Eigen::Matrix3d& M_AB);

// Places that look alike.
std::vector<PixelPair> FeaturePairs(const CameraModel& camera, RegisteredImage& a, RegisteredImage& b);

struct RegistrationOptions {
  double threshold_px = 1.5;
  int min_pairs = 15;
  double min_share = 0.25;  // of the followed places that must agree
};

// The motion between two images that was nearly guessed: within some 30 px. None: they do not agree.
std::optional<MotionEstimate> RegisterNear(MosaicModel model, const CameraModel& camera, RegisteredImage& a,
                                           RegisteredImage& b, const Eigen::Matrix3d& M_AB,
                                           const RegistrationOptions& options);
// The same without a guess: by features, then followed from what they say.
std::optional<MotionEstimate> RegisterFar(MosaicModel model, const CameraModel& camera, RegisteredImage& a,
                                          RegisteredImage& b, const RegistrationOptions& options);

// The share of b that a shows as well, from 0 to 1.
double SharedWith(const CameraModel& camera, const Eigen::Matrix3d& M_AB);

}  // namespace kestrel::vision
