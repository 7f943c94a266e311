// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace kestrel::vision {

// An image at scales half of each other, the finest first, each CV_32FC1 in grey levels and smoothed a little:
// the centre of pixel (u, v) of level k lies at (2^k u, 2^k v) of level 0.
struct ImagePyramid {
  std::vector<cv::Mat> levels;
};

inline constexpr int kMaxPyramidLevels = 7;
inline constexpr int kMinPyramidSide_px = 12;  // no level is smaller

// Of an image CV_8UC1 or CV_32FC1. A pyramid that is filled again with an image of the same size takes no new
// memory.
void FillPyramid(const cv::Mat& grey, ImagePyramid& pyramid, int levels = kMaxPyramidLevels);

}  // namespace kestrel::vision
