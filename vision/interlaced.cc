// SPDX-License-Identifier: Apache-2.0
#include "vision/interlaced.h"

#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

constexpr int kBlock_px = 16;
constexpr double kMinContrast = 8;  // of a block that tells something: RMS of a row's difference, grey levels
constexpr double kCombed = 2;       // squared differences to the next row over those to the one beyond it
constexpr double kMinShare = 0.05;  // of the blocks that tell something
constexpr int kMinBlocks = 8;

}  // namespace

bool Interlaced(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  int telling = 0, combed = 0;
  for (int y = 0; y + kBlock_px + 2 <= grey.rows; y += kBlock_px) {
    for (int x = 0; x + kBlock_px <= grey.cols; x += kBlock_px) {
      std::int64_t next = 0, beyond = 0;
      for (int r = y; r < y + kBlock_px; ++r) {
        const auto *a = grey.ptr<std::uint8_t>(r) + x, *b = grey.ptr<std::uint8_t>(r + 1) + x,
                   *c = grey.ptr<std::uint8_t>(r + 2) + x;
        for (int i = 0; i < kBlock_px; ++i) {
          next += (a[i] - b[i]) * (a[i] - b[i]);
          beyond += (a[i] - c[i]) * (a[i] - c[i]);
        }
      }
      const double least = kMinContrast * kMinContrast * kBlock_px * kBlock_px;
      telling += static_cast<double>(next + beyond) >= least;
      combed += static_cast<double>(next) >= least &&
                static_cast<double>(next) > kCombed * static_cast<double>(beyond);
    }
  }
  return combed >= kMinBlocks && combed >= kMinShare * telling;
}

cv::Mat FirstField(const cv::Mat& image) {
  cv::Mat result = image.clone();
  for (int r = 1; r < image.rows; r += 2) {
    if (r + 1 < image.rows)
      cv::addWeighted(image.row(r - 1), 0.5, image.row(r + 1), 0.5, 0, result.row(r));
    else
      image.row(r - 1).copyTo(result.row(r));
  }
  return result;
}

}  // namespace kestrel::vision
