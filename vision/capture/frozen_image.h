// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::vision {

// Noise never repeats itself: the same image again is an old one under a new time, and to follow it would be
// to fly blind without knowing.
class FrozenImage {
 public:
  // Whether this image is the one before, to the last bit. An empty one is none.
  bool Is(const cv::Mat& image);

 private:
  cv::Mat last_;
};

}  // namespace kestrel::vision
