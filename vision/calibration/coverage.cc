// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/coverage.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {

using Eigen::Vector2d;

Coverage CoverageOf(const Calibration& calibration, std::span<const cv::Mat> images) {
  Coverage c;
  const double width = WidthPx(calibration.camera), height = HeightPx(calibration.camera);
  // A cell is as bright as in the image where it is brightest.
  cv::Mat brightest(c.rows, c.cols, CV_32FC1, cv::Scalar(0));
  for (const cv::Mat& image : images) {
    cv::Mat cells;
    cv::resize(image, cells, brightest.size(), 0, 0, cv::INTER_AREA);
    cells.convertTo(cells, CV_32F);
    cv::max(brightest, cells, brightest);
  }
  constexpr double kDark = 0.1;
  const double dark = kDark * cv::mean(brightest)[0];
  for (int row = 0; row < c.rows; ++row) {
    for (int col = 0; col < c.cols; ++col) {
      const Vector2d middle((col + 0.5) * width / c.cols - 0.5, (row + 0.5) * height / c.rows - 0.5);
      c.in_lens.push_back(Ray(calibration.camera, middle) && !(brightest.at<float>(row, col) < dark));
    }
  }
  c.corners.resize(c.in_lens.size());
  for (const CalibratedView& view : calibration.views) {
    for (const CornerResidual& corner : view.corners) {
      if (!corner.used) continue;
      const int col = std::clamp(static_cast<int>((corner.pixel.x() + 0.5) * c.cols / width), 0, c.cols - 1);
      const int row = std::clamp(static_cast<int>((corner.pixel.y() + 0.5) * c.rows / height), 0, c.rows - 1);
      ++c.corners[static_cast<std::size_t>(row * c.cols + col)];
    }
  }
  int in_lens = 0, covered = 0;
  for (std::size_t i = 0; i < c.in_lens.size(); ++i) {
    in_lens += c.in_lens[i] || c.corners[i] > 0;
    covered += c.corners[i] > 0;
  }
  c.share = static_cast<double>(covered) / std::max(in_lens, 1);
  return c;
}

}  // namespace kestrel::vision
