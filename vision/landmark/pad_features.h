// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/features/features.h"
#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// Finds a pad of which only a part is in view, where PadDetector has no rectangle to go by: features
// (thesis 3.2.2) of the image matched with those of the reference, and a RANSAC homography. Some tens of
// milliseconds an image.
class PadFeatures {
 public:
  PadFeatures(const PadReference& reference, const Pinhole& camera,
              FeatureDetector detector = FeatureDetector::kSift);

  // H_w, the homography from T, m, to the image (CV_8UC1), good to about a pixel. None: too few matches
  // agree.
  std::optional<Eigen::Matrix3d> Find(const cv::Mat& grey, std::uint32_t seed) const;

 private:
  Pinhole camera_;
  FeatureDetector detector_;
  Features reference_;
  std::vector<Eigen::Vector2d> places_;  // of the reference's features, in T, m
};

}  // namespace kestrel::vision
