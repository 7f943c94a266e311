// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/target/colour_model.h"

namespace kestrel::vision {

// A spot of a light's colour.
struct LightSpot {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // px, weighted by how much of the colour each pixel has
  double area_px = 0;                                // of the pixels that have it
  int colour = 1;                                    // which of the colours looked for, from 1
};

struct LightDetectorOptions {
  double min_area_px = 2, max_area_px = 900;
  int max_spots = 12;  // of each colour, the strongest
};

// How much each pixel of an image (CV_8UC3) has of a hue: the component of its colour, less its grey, along
// that hue, 0 to 255, CV_8UC1. It is linear, so that what covers a pixel by half has half of it.
cv::Mat HueComponent(const cv::Mat& bgr, double hue_deg);

// The spots of these colours within a part of an image (CV_8UC3), in pixels of the image: connected pixels that are
// of the colour (ColourModel), each measured together with the ring of pixels around it. What touches the border of
// the part is left out, as its other half is not seen.
std::vector<LightSpot> FindLights(const cv::Mat& bgr, const cv::Rect& within,
                                  const std::vector<ColourRange>& colours,
                                  const LightDetectorOptions& options = {});

}  // namespace kestrel::vision
