// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/image_pyramid.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {

void FillPyramid(const cv::Mat& grey, ImagePyramid& pyramid, int levels) {
  pyramid.levels.resize(static_cast<std::size_t>(std::max(levels, 1)));
  cv::Mat& finest = pyramid.levels.front();
  grey.convertTo(finest, CV_32F);
  // Against noise, and because a gradient by differences is true of smooth images alone.
  cv::GaussianBlur(finest, finest, {3, 3}, 0.8, 0.8, cv::BORDER_REPLICATE);
  std::size_t k = 1;
  for (; k < pyramid.levels.size(); ++k) {
    const cv::Mat& finer = pyramid.levels[k - 1];
    if (std::min(finer.rows, finer.cols) < 2 * kMinPyramidSide_px) break;
    cv::pyrDown(finer, pyramid.levels[k], {}, cv::BORDER_REPLICATE);
  }
  pyramid.levels.resize(k);
}

}  // namespace kestrel::vision
