// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/imgproc.hpp>

namespace kestrel::vision {

// A picture of random blotches, CV_8UC1.
inline cv::Mat RandomScene(const cv::Size& size, int seed, double blotch_px = 2) {
  cv::Mat fine(size, CV_32FC1), scene;
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(fine, cv::RNG::NORMAL, 0, 45 * blotch_px);
  cv::GaussianBlur(fine, fine, {}, blotch_px);
  fine.convertTo(scene, CV_8U, 3, 128);
  return scene;
}

}  // namespace kestrel::vision
