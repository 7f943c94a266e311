// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/panorama_strip.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/camera/views.h"

namespace kestrel::vision {

namespace {

constexpr int kSurroundings = 24;  // columns to each side
constexpr float kClip = 3;         // standard deviations

int ReductionFor(const CameraModel& camera) {
  const double px = MeanResolution(camera) * kStripGrid.step / 2;  // per column
  return px > 3.2 ? 4 : px > 1.6 ? 2 : 1;
}

}  // namespace

StripMaker::StripMaker(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden)
    : sampler_(camera, forbidden),
      nose_C_(R_BC.transpose() * Eigen::Vector3d::UnitX()),
      reduction_(ReductionFor(camera)) {}

PanoramaStrip StripMaker::Make(const cv::Mat& image, const Eigen::Vector3d& down_C) const {
  cv::Mat reduced = image;
  if (reduction_ > 1)
    cv::resize(image, reduced, {image.cols / reduction_, image.rows / reduction_}, 0, 0, cv::INTER_AREA);
  // Detail as fine as a column looks different from each place: it makes strips less alike, and turns them.
  cv::Mat smooth;
  cv::blur(reduced, smooth, {3, 3});
  const BandSamples band = sampler_.Read(smooth, reduction_, HorizontalAbout(down_C, nose_C_), kStripGrid);
  const int columns = kStripGrid.azimuths, rows = kStripGrid.elevations;
  PanoramaStrip strip;
  strip.pattern.create(rows, columns, CV_32FC1);
  strip.shown.create(rows, columns, CV_32FC1);
  std::vector<float> grey(static_cast<std::size_t>(columns)), sums(static_cast<std::size_t>(columns) + 1),
      counts(static_cast<std::size_t>(columns) + 1);
  double square = 0, total = 0;
  for (int j = 0; j < rows; ++j) {
    auto* pattern = strip.pattern.ptr<float>(j);
    auto* shown = strip.shown.ptr<float>(j);
    sums[0] = counts[0] = 0;
    for (int i = 0; i < columns; ++i) {
      const auto& c = band.colour.at<cv::Vec3f>(i, j);
      const auto at = static_cast<std::size_t>(i);
      shown[i] = band.shown.at<uchar>(i, j) ? 1.0f : 0.0f;
      // The logarithm, so that light that changes as a whole drops out.
      grey[at] = std::log(8 + (c[0] + 2 * c[1] + c[2]) / 4);
      sums[at + 1] = sums[at] + shown[i] * grey[at];
      counts[at + 1] = counts[at] + shown[i];
    }
    const auto between = [&](const std::vector<float>& s, int from, int to) {  // wraps around
      const auto n = static_cast<std::size_t>(columns);
      const auto a = static_cast<std::size_t>((from + columns) % columns);
      const auto b = static_cast<std::size_t>((to + columns) % columns);
      return a < b ? s[b] - s[a] : s[n] - s[a] + s[b];
    };
    for (int i = 0; i < columns; ++i) {
      pattern[i] = 0;
      if (shown[i] == 0) continue;
      const float n = between(counts, i - kSurroundings, i + kSurroundings + 1);
      pattern[i] =
          grey[static_cast<std::size_t>(i)] - between(sums, i - kSurroundings, i + kSurroundings + 1) / n;
      square += static_cast<double>(pattern[i]) * pattern[i];
      total += 1;
    }
  }
  const float scale = total > 0 ? static_cast<float>(1 / std::sqrt(square / total + 1e-4)) : 0;
  strip.pattern *= scale;
  strip.pattern = cv::min(cv::max(strip.pattern, -kClip), kClip);
  int seen = 0;
  for (int i = 0; i < columns; ++i) seen += strip.shown.at<float>(rows / 2, i) > 0;
  strip.seen = static_cast<double>(seen) / columns;
  return strip;
}

}  // namespace kestrel::vision
