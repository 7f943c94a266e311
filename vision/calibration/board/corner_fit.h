// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace kestrel::vision {

// A corner where two edges cross and four fields meet, black and white by turns, as it is expected in an
// image. The edges follow x and y of the board; a lens bends them.
struct CornerGuess {
  Eigen::Vector2d pixel;
  Eigen::Vector2d along_x, along_y;  // of the edges, px; any length
  double bend_x = 0, bend_y = 0;     // curvature of each edge towards the other axis, 1/px
  bool black_between = false;        // the field between +x and +y
  double radius_px = 5;              // up to which nothing else is seen
};

struct FittedCorner {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  // px^2, for noise as large as what the fit leaves
  double blur_px = 0;          // standard deviation of the light's spread, lens and pixel together
  double contrast = 0;         // white less black, grey levels
};

// The place of a corner, by least squares over the disc of that radius: the light of four fields with two
// edges, free in their directions, blurred alike, on a slope of brightness. What is seen around a corner is
// the same after half a turn, so neither blur nor the perspective shifts it; what would, the edges'
// curvature, comes with the guess. grey: CV_8UC1. None: the disc leaves the image, or what is in it is not
// such a corner within half the radius.
std::optional<FittedCorner> FitCorner(const cv::Mat& grey, const CornerGuess& guess);

// The best whole-pixel place for such a corner within some pixels of the guess, by correlation. None: nothing
// there is like it.
std::optional<Eigen::Vector2d> SearchCorner(const cv::Mat& grey, const CornerGuess& guess, double within_px);

}  // namespace kestrel::vision
