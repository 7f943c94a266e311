// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/outline/pad_shapes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

constexpr double kMinRectangle = 0.3;  // share of the pad that such a rectangle or circle covers
constexpr double kRoundCircle = 1.03;  // ratio of its axes

double AreaOf(const Quad& quad) {
  const Eigen::Vector2d a = quad[2] - quad[0], b = quad[3] - quad[1];
  return std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
}

}  // namespace

PadShapes ShapesOf(const cv::Mat& image, const Eigen::Matrix3d& pixel_from_T,
                   const std::vector<Eigen::Vector2d>& outline) {
  PadShapes shapes;
  auto& [rectangles, circles] = shapes;
  rectangles.push_back({outline[0], outline[1], outline[2], outline[3]});
  constexpr int kBorder_px = 20;
  cv::Mat bordered;
  cv::copyMakeBorder(image, bordered, kBorder_px, kBorder_px, kBorder_px, kBorder_px, cv::BORDER_CONSTANT,
                     128);
  const Eigen::Matrix3d T_from_pixel = pixel_from_T.inverse();
  const double side = std::sqrt(AreaOf(rectangles[0]));
  const Contours contours = LargeContours(bordered);
  for (const Quad& quad : QuadsOf(contours)) {
    Quad quad_T;
    for (int k = 0; k < 4; ++k)
      quad_T[k] = Transfer(T_from_pixel, quad[k] - Eigen::Vector2d(kBorder_px, kBorder_px));
    if (AreaOf(quad_T) < kMinRectangle * side * side) continue;
    // First the corner nearest to the picture's top left, as in the outline.
    int first = 0;
    for (int k = 1; k < 4; ++k) {
      if ((quad_T[k] - outline[0]).norm() < (quad_T[first] - outline[0]).norm()) first = k;
    }
    std::rotate(quad_T.begin(), quad_T.begin() + first, quad_T.end());
    const bool known = std::any_of(rectangles.begin(), rectangles.end(), [&](const Quad& other) {
      return (other[0] - quad_T[0]).norm() + (other[2] - quad_T[2]).norm() < 0.02 * side;
    });
    if (!known) rectangles.push_back(quad_T);
  }
  for (const Ellipse& ellipse : EllipsesOf(contours)) {
    const Eigen::Vector2d middle_T =
        Transfer(T_from_pixel, ellipse.middle - Eigen::Vector2d(kBorder_px, kBorder_px));
    const Eigen::Matrix2d axes_T = T_from_pixel.topLeftCorner<2, 2>() * ellipse.axes;
    const double a = axes_T.col(0).norm(), b = axes_T.col(1).norm(), radius = std::sqrt(a * b);
    if (!(std::max(a, b) < kRoundCircle * std::min(a, b)) || M_PI * a * b < kMinRectangle * side * side)
      continue;
    const bool known = std::any_of(circles.begin(), circles.end(), [&](const PadShapes::Circle& other) {
      return (other.middle - middle_T).norm() + std::abs(other.radius - radius) < 0.02 * side;
    });
    if (!known) circles.push_back({middle_T, radius});
  }
  return shapes;
}

}  // namespace kestrel::vision
