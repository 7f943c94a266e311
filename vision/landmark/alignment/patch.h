// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/landmark/alignment/template_level.h"

namespace kestrel::vision {

// The image under a template, I(W(x)) of thesis (3.1), in rows of the template's width.
struct Patch {
  struct Span {
    int begin = 0, end = 0;  // columns that lie in the image; they are without a gap, as the image is convex
  };
  std::vector<float> grey;  // rows * cols; outside the spans anything
  std::vector<Span> spans;  // of each row
  int cols = 0, count = 0;  // count: pixels in the spans
  std::vector<float> u, v;  // of one row: scratch
};

// image_from_pixel: from the pixels of the patch to those of the image (CV_32FC1), between whose centres is
// interpolated bilinearly. Where the point lies behind the plane at infinity, it is not in the image.
void Sample(const cv::Mat& image, const Eigen::Matrix3d& image_from_pixel, int cols, int rows, Patch& patch);

// The gradient of the patch itself by the normal coordinates of a template of its size, for the pixels in
// `spans`, which are those of the patch less what has no neighbour in it.
struct PatchGradient {
  PixelPairs gradient;
  std::vector<Patch::Span> spans;
  int count = 0;
};
void Differentiate(const Patch& patch, const TemplateLevel& level, PatchGradient& slope);

}  // namespace kestrel::vision
