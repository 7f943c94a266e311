// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/horizon/band_sampler.h"

namespace kestrel::vision {

// Which pixels show sky, for an attitude known to a degree or so: what lies above the contour between sky and
// ground (vision/horizon/skyline_profile.h). Where a meridian shows no contour, its neighbours say, and
// failing them the horizontal.
enum SkyZone : unsigned char {
  kNoSky = 0,
  kNearGround = 128,  // sky, but within the margin of the contour
  kFreeSky = 255      // sky, and so are the directions around it
};
class SkyMask {
 public:
  // forbidden: CV_8UC1 of the camera's size, not 0 where the aircraft itself is seen; or empty.
  SkyMask(const CameraModel& camera, const cv::Mat& forbidden);

  // quarter: the image (CV_8UC3) at a quarter of its size. down_C: unit vector, known to down_sigma (rad).
  // margin: rad above the highest contour nearby, where the sky is free. Returns
  // CV_8UC1 of half the camera's size, of SkyZone.
  cv::Mat Find(const cv::Mat& quarter, const Eigen::Vector3d& down_C, double down_sigma, double margin) const;

 private:
  BandSampler sampler_;
  cv::Size half_;
  std::vector<Eigen::Vector3f> rays_;  // of the half image's pixels; zero where nothing may be seen
};

}  // namespace kestrel::vision
