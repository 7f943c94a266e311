// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// A straight line among the pixels of a view: normal . pixel = offset, with the normal (of length 1) towards
// the sky.
struct SkyBorder {
  Eigen::Vector2d normal = Eigen::Vector2d(0, -1);
  double offset = 0;  // px
};

// What a camera sees, as a pinhole of few pixels without distortion would, so that every horizon is straight:
// for lenses that look one way. What lies more than 65 degrees off the optical axis is left out.
class PlaneView {
 public:
  // forbidden: CV_8UC1 of the camera's size, not 0 where the aircraft itself is seen; or empty.
  PlaneView(const CameraModel& camera, const cv::Mat& forbidden);

  // image: CV_8UC3 of the camera's size. Returns CV_8UC3 of size().
  cv::Mat Of(const cv::Mat& image) const;

  cv::Size size() const { return shown_.size(); }
  // CV_8UC1 of size(): 0 where the camera shows nothing, or only the aircraft.
  const cv::Mat& shown() const { return shown_; }
  double focal_px() const { return focal_px_; }

  // The "down" whose horizon, dip below the horizontal (rad), is about that line; and back, without a dip.
  Eigen::Vector3d DownOf(const SkyBorder& line, double dip) const;
  SkyBorder BorderOf(const Eigen::Vector3d& down_C) const;
  Eigen::Vector3d RayOf(const Eigen::Vector2d& pixel) const;  // unit, in C

 private:
  cv::Size camera_size_, reduced_;
  double focal_px_ = 1;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();  // the optical axis, px
  cv::Mat map_x_, map_y_;                             // into the reduced image, px
  cv::Mat shown_;
};

}  // namespace kestrel::vision
