// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>

namespace kestrel::vision {

// Where the pixels of a picture are found in an image, as cv::remap takes it. kNowhere: not in it.
struct PixelMap {
  static constexpr float kNowhere = -1e6F;
  cv::Mat u, v;  // CV_32FC1, px
};

// The map of the pixels of `part`, whose source is given exactly at every `step`-th pixel and at the rims, and
// bilinear between. Where one of the four around a pixel has no source, the pixel's own is asked for.
PixelMap MakePixelMap(const cv::Rect& part, int step,
                      const std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>& source);

}  // namespace kestrel::vision
