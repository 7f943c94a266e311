// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/outline/outlines.h"
#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// Finds the whole pad in one image without any guess: it stands in for the person who clicks four corners in
// thesis 4.4. Quadrilaterals of the image are matched with the large rectangles of the pad's own picture (its
// outline, its frames) of the same aspect ratio (thesis 3.21), ellipses with its large circles, and what such a
// match makes of the image is compared with the reference appearance, in every direction: as it is and, where
// nothing then looks like the pad, with its light evened out, as part of it may be in the shade.
class PadDetector {
 public:
  PadDetector(const PadReference& reference, const Pinhole& camera);

  // H_w, the homography from T, m, to the image (CV_8UC1), good to about a pixel, and to some 8 where part of
  // the pad is in the shade. None: nothing looks like the pad.
  std::optional<Eigen::Matrix3d> Detect(const cv::Mat& grey) const;

 private:
  void AddQuads(const std::vector<Quad>& quads, std::vector<Eigen::Matrix3d>& candidates) const;
  void AddCircles(const Contours& contours, std::vector<Eigen::Matrix3d>& candidates) const;

  Pinhole camera_;
  PadReference::Level level_;  // the scale at which candidates are compared
  cv::Mat evenly_lit_;         // the same, as it is compared where light and shade lie over the pad
  PadShapes shapes_;
};

}  // namespace kestrel::vision
