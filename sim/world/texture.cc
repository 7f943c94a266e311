// SPDX-License-Identifier: Apache-2.0
#include "sim/world/texture.h"

#include <algorithm>
#include <bit>
#include <opencv2/imgproc.hpp>

namespace kestrel::sim {
namespace {

constexpr unsigned kMaxSide_px = 4096;

int SideOf(int px) {
  return static_cast<int>(std::min(kMaxSide_px, std::bit_ceil(static_cast<unsigned>(px))));
}

// One side at a time: to shrink means to average, to enlarge to interpolate.
cv::Mat Resized(const cv::Mat& picture, const cv::Size& size) {
  cv::Mat resized;
  const bool shrinks = size.width < picture.cols || size.height < picture.rows;
  cv::resize(picture, resized, size, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

}  // namespace

cv::Mat TexturePicture(const cv::Mat& picture) {
  const cv::Size size(SideOf(picture.cols), SideOf(picture.rows));
  if (size == picture.size() && picture.isContinuous()) return picture;
  return Resized(Resized(picture, {size.width, picture.rows}), size);
}

}  // namespace kestrel::sim
