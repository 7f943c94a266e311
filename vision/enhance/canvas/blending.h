// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "vision/enhance/canvas/pixel_map.h"

namespace kestrel::vision {

// How the pixels of several images that fall on one place become one, thesis 4.3.
enum class Blending {
  kAverage,
  kFeather,  // mean weighted by the quadratic filter, which is 1 in the middle of an image and 0 at its rim
  kNearest   // the one that is nearest to the middle of its image
};

// The weight of a pixel of an image: the more, the more it counts; 0 or less: not at all. Average: 1. Feather:
// f(u, v) = (1 - x^2)(1 - y^2), where x and y are the distances from the middle in units of half the width and
// half the height. The thesis prints them in pixels, of which f would be positive at the middle alone. Nearest:
// 1 less the squared distance from the middle in units of the distance of the corners.
double BlendWeight(Blending blending, cv::Size image, double u, double v);

// The same of all pixels of a map, CV_32FC1; 0 off the image.
cv::Mat BlendWeights(Blending blending, cv::Size image, const PixelMap& map);

}  // namespace kestrel::vision
