// SPDX-License-Identifier: Apache-2.0
#include "sim/world/print.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/random.h"

namespace kestrel::sim {

cv::Mat Printed(const cv::Mat& picture, const Eigen::Vector2d& size_m, const PrintParameters& print,
                std::uint64_t seed) {
  const Eigen::Vector2d px_per_mm(picture.cols / size_m.y() / 1e3, picture.rows / size_m.x() / 1e3);
  cv::Mat inked;
  picture.convertTo(inked, CV_32F, (print.white - print.black) / 255, print.black);
  if (print.spread_mm > 0)
    cv::GaussianBlur(inked, inked, {}, print.spread_mm * px_per_mm.x(), print.spread_mm * px_per_mm.y(),
                     cv::BORDER_REPLICATE);
  if (print.grain_grey > 0) {
    const auto grains = [&](int px, double px_per_mm_of_side) {
      return std::clamp(static_cast<int>(std::lround(px / (px_per_mm_of_side * print.grain_mm))), 1, px);
    };
    cv::Mat grain(grains(picture.rows, px_per_mm.y()), grains(picture.cols, px_per_mm.x()), CV_32FC1);
    cv::RNG random(RandomStream(seed, "print").Bits() | 1);
    random.fill(grain, cv::RNG::NORMAL, 0, print.grain_grey);
    cv::resize(grain, grain, picture.size(), 0, 0, cv::INTER_NEAREST);
    if (inked.channels() == 3) cv::cvtColor(grain, grain, cv::COLOR_GRAY2BGR);
    inked += grain;
  }
  cv::Mat printed;
  inked.convertTo(printed, CV_8U);
  return printed;
}

}  // namespace kestrel::sim
