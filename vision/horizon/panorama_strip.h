// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/horizon/band_sampler.h"

namespace kestrel::vision {

// What is to be seen all round at the height of the horizon, by the measured vertical: a turn of the aircraft
// shifts its columns and does nothing else, at any tilt. Rows from the lowest elevation up; columns by
// azimuth clockwise from the nose.
struct PanoramaStrip {
  cv::Mat pattern;  // CV_32F: brightness against its surroundings to the left and right, clipped; 0 unseen
  cv::Mat shown;    // CV_32F, 0 or 1
  double seen = 0;  // share of the azimuths
};

// Little of the ground: it is near, and shifts as the camera moves.
inline constexpr BandGrid kStripGrid{720, 15, -2.5 * M_PI / 180, M_PI / 180};

// Makes strips of one camera's images.
class StripMaker {
 public:
  StripMaker(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden);
  // image: CV_8UC3 of the camera's size.
  PanoramaStrip Make(const cv::Mat& image, const Eigen::Vector3d& down_C) const;

 private:
  BandSampler sampler_;
  Eigen::Vector3d nose_C_;
  int reduction_;  // of the image, so that its pixels are no finer than the strip's
};

}  // namespace kestrel::vision
