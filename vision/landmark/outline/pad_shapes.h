// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/landmark/outline/outlines.h"

namespace kestrel::vision {

// The rectangles and circles of a pad's picture by which it is found, in its frame T, m.
struct PadShapes {
  struct Circle {
    Eigen::Vector2d middle;
    double radius;
  };
  std::vector<Quad> rectangles;  // the first is the outline; clockwise from the picture's top left
  std::vector<Circle> circles;
};

// image: the pad seen from above, CV_8UC1. pixel_from_T: affine, of T to its pixels. outline: as of PadReference. Those
// that cover a good part of the pad.
PadShapes ShapesOf(const cv::Mat& image, const Eigen::Matrix3d& pixel_from_T,
                   const std::vector<Eigen::Vector2d>& outline);

}  // namespace kestrel::vision
