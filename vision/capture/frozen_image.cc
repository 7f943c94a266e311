// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/frozen_image.h"

#include <cstring>

namespace kestrel::vision {
namespace {

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || a.size() != b.size() || a.type() != b.type()) return false;
  const std::size_t bytes = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int y = 0; y < a.rows; ++y)
    if (std::memcmp(a.ptr(y), b.ptr(y), bytes) != 0) return false;
  return true;
}

}  // namespace

bool FrozenImage::Is(const cv::Mat& image) {
  const bool same = SamePixels(image, last_);
  image.copyTo(last_);
  return same;
}

}  // namespace kestrel::vision
