// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

// Segmentation by linking the pixels of an image pyramid to their fathers (H. J. Antonisse, "Image Segmentation
// in Pyramids", 1982), as thesis 6.3.1 has it. OpenCV had it until its version 2.4; this is our own.
namespace kestrel::vision {

struct PyramidSegmentationOptions {
  int levels = 4;         // above the image
  double link_grey = 15;  // a pixel is linked to a father that differs by less
  double join_grey = 4;   // segments that differ by less become one, wherever they are
  int rounds = 3;         // of linking and averaging, on each level
};

// A grey image (CV_8UC1) with each pixel replaced by the mean of its segment. Each pixel is linked to the most
// similar of the four pixels above it that cover it, which then becomes the mean of what is linked to it. What
// is unlike all of them begins a segment of its own.
cv::Mat SegmentByPyramid(const cv::Mat& grey, const PyramidSegmentationOptions& options = {});

}  // namespace kestrel::vision
