// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace kestrel::bench {

// A flat thing to be tracked.
struct PlanarPicture {
  std::string name;
  cv::Mat grey;  // CV_8UC1, kPictureSize
};

inline const cv::Size kPictureSize(1024, 768);

// One of each kind, drawn by the seed: printed text, a rich texture, a poor sign of few shapes, and a pattern
// that repeats itself within a frame.
std::vector<PlanarPicture> PlanarPictures(std::uint64_t seed);

// Blotches of several sizes, as grass and gravel or a wall have them. contrast: grey levels of each size.
cv::Mat Blotches(cv::Size size, int finest_px, double contrast, std::uint64_t seed);

}  // namespace kestrel::bench
