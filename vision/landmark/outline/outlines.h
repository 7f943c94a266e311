// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

// Outlines of flat things that are seen aslant.
namespace kestrel::vision {

// The larger ones of the closed borders of light and dark in an image (CV_8UC1): of what is brighter than the rest of
// the image, and than its neighbourhood.
using Contours = std::vector<std::vector<cv::Point>>;
Contours LargeContours(const cv::Mat& grey);
// Of what is darkest in the image, as a black frame is though part of it is in the shade.
Contours DarkContours(const cv::Mat& grey);

using Quad = std::array<Eigen::Vector2d, 4>;  // corners in px, clockwise in the image

// What a rectangle may look like.
std::vector<Quad> QuadsOf(const Contours& contours);

// What a circle may look like: the points middle + axes * (cos t, sin t). The axes, px, are at right angles.
struct Ellipse {
  Eigen::Vector2d middle;
  Eigen::Matrix2d axes;  // its columns; their determinant is positive
};
std::vector<Ellipse> EllipsesOf(const Contours& contours);

}  // namespace kestrel::vision
