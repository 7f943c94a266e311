// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_reference.h"
#include "vision/photometric/photometric_offset.h"

namespace kestrel::scenarios {

// The grey levels of the pad as they are wanted, drawn from its known picture, and a frame beside them.
class PhotometricSight {
 public:
  // X_DT: the pad in the camera at the goal, level.
  PhotometricSight(const vision::PadReference& pad, const vision::Pinhole& camera, const Pose& X_DT,
                   double blur_px);
  // grey: a frame as the camera gave it; R_VC: levels it.
  std::optional<vision::PhotometricFix> Compare(const cv::Mat& grey, const Eigen::Quaterniond& R_VC) const;

  const cv::Mat& wanted() const { return wanted_; }

 private:
  vision::Pinhole camera_;
  cv::Mat wanted_, mask_;
  vision::PhotometricOffset offset_;
};

}  // namespace kestrel::scenarios
