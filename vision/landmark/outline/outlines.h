// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

// Outlines of flat things that are seen aslant, among the edges of light and dark in an image (CV_8UC1).
namespace kestrel::vision {

using Quad = std::array<Eigen::Vector2d, 4>;  // corners in px, clockwise in the image

// What a rectangle may look like.
std::vector<Quad> FindQuads(const cv::Mat& grey);
// The same of what is darkest in the image, as a black frame is though part of it is in the shade.
std::vector<Quad> FindDarkQuads(const cv::Mat& grey);

// What a circle may look like: the points middle + axes * (cos t, sin t). The axes, px, are at right angles.
struct Ellipse {
  Eigen::Vector2d middle;
  Eigen::Matrix2d axes;  // its columns; their determinant is positive
};
std::vector<Ellipse> FindEllipses(const cv::Mat& grey);

}  // namespace kestrel::vision
