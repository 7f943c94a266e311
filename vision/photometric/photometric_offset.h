// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/camera/pinhole.h"

namespace kestrel::vision {

// Where a level camera is off a place, by the grey levels of its image alone.
struct PhotometricFix {
  Eigen::Vector3d p_V =
      Eigen::Vector3d::Zero();  // of the camera from that place, m, x right, y down, z forward
  double yaw = 0;               // clockwise about the optical axis, rad
  double residual_grey = 0;     // RMS of what is left of the difference of the images
  double gain = 1;              // of the image over that which is wanted
};

// Photometric visual servoing: Collewet and Marchand, "Photometric visual servoing", IEEE Trans. Robotics
// 27(4), 2011. The feature is the whole image, s = I, and its interaction matrix is that of the points under
// its gradients,
//
//   L_I = -grad I^T L_x,   xi = L_I^+ (I - I*)
//
// for a plane across the optical axis at the depth Z*, by the four freedoms of a level aircraft. No feature is
// extracted, matched or tracked.
//
// Deviations: the gradients are the mean of those of both images (Malis's matrix of second order), and a gain
// and an offset of brightness are found with the offset of place, because I* is drawn and not taken.
class PhotometricOffset {
 public:
  // wanted: the image there, CV_8UC1; mask: 255 where it counts; both of the camera's size. blur_px: of a
  // Gaussian over both images, which widens the reach. Throws std::invalid_argument: no pixel counts.
  PhotometricOffset(const cv::Mat& wanted, const cv::Mat& mask, const Pinhole& camera, double depth_m,
                    double blur_px);

  // An image of the level camera, CV_8UC1, and where it shows anything, 255 there. None: it shows too little of
  // what counts, or nothing that tells where it is.
  std::optional<PhotometricFix> Compare(const cv::Mat& image, const cv::Mat& shown) const;

 private:
  Pinhole camera_;
  double depth_m_, blur_px_;
  cv::Mat wanted_, du_, dv_;  // CV_32F
  cv::Mat mask_;
  int pixels_ = 0;
};

}  // namespace kestrel::vision
