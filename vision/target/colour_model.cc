// SPDX-License-Identifier: Apache-2.0
#include "vision/target/colour_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace kestrel::vision {

namespace {

constexpr int kMinPixels = 30;
constexpr int kMinSaturation = 50, kMinValue = 25;  // of 255: below them a hue is noise
constexpr double kQuantile = 0.03;                  // of the patch, outside either gate
constexpr int kHueMargin = 12;                      // of a gate beyond what the patch showed

int Quantile(std::vector<int>& values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

const char* NameOf(TrainingState state) {
  switch (state) {
    case TrainingState::kTrained:
      return "learnt";
    case TrainingState::kBadPatch:
      return "bad patch";
    case TrainingState::kTooFewPixels:
      return "too few pixels";
    case TrainingState::kTooGrey:
      return "too grey";
    case TrainingState::kTooManyColours:
      return "too many colours";
    case TrainingState::kLikeSurroundings:
      return "like its surroundings";
  }
  return "?";
}

ColourModel::ColourModel(const ColourRange& r)
    : min_saturation_(static_cast<int>(std::lround(255 * r.min_saturation))),
      min_value_(static_cast<int>(std::lround(255 * r.min_value))),
      max_value_(static_cast<int>(std::lround(255 * r.max_value))) {
  for (int bin = 0; bin < kBins; ++bin) {
    const double away = std::abs(std::remainder(bin * 360.0 / kBins - r.hue_deg, 360.0));
    // A soft rim of a third of the width: noise in the hue must not switch pixels on and off.
    const double rim = r.hue_half_width_deg / 3;
    const double weight = std::clamp((r.hue_half_width_deg + rim / 2 - away) / rim, 0.0, 1.0);
    hue_[static_cast<std::size_t>(bin)] = static_cast<std::uint8_t>(std::lround(255 * weight));
  }
}

TrainedColour ColourModel::Train(const cv::Mat& bgr, const cv::Mat& mask) {
  TrainedColour lesson;
  if (bgr.type() != CV_8UC3 || mask.type() != CV_8UC1 || bgr.size() != mask.size() || bgr.empty())
    return lesson;
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV_FULL);
  std::vector<int> saturations, values;
  std::array<double, kBins> counts{};
  int pixels = 0;
  for (int y = 0; y < hsv.rows; ++y)
    for (int x = 0; x < hsv.cols; ++x) {
      if (mask.at<uchar>(y, x) == 0) continue;
      ++pixels;
      const auto& p = hsv.at<cv::Vec3b>(y, x);
      if (p[1] < kMinSaturation || p[2] < kMinValue) continue;
      saturations.push_back(p[1]), values.push_back(p[2]);
      counts[p[0]] += 1;
    }
  if (pixels < kMinPixels) {
    lesson.state = TrainingState::kTooFewPixels;
    return lesson;
  }
  if (2 * static_cast<int>(values.size()) < pixels) {
    lesson.state = TrainingState::kTooGrey;
    return lesson;
  }
  // Smoothed over a few degrees: a small patch fills its histogram with gaps.
  constexpr int kReach = 5;
  std::array<double, kBins> smooth{};
  for (int bin = 0; bin < kBins; ++bin)
    for (int d = -kReach; d <= kReach; ++d)
      smooth[static_cast<std::size_t>(bin)] +=
          (kReach + 1 - std::abs(d)) * counts[static_cast<std::size_t>((bin + d + kBins) % kBins)];
  const double most = *std::max_element(smooth.begin(), smooth.end());
  ColourModel& model = lesson.model;
  int wide = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    // Whatever is a fair part of the patch counts fully: the target is not its commonest hue alone.
    model.hue_[bin] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, 4 * smooth[bin] / most)));
    wide += model.hue_[bin] > 127;
  }
  model.min_saturation_ = std::max(kMinSaturation, Quantile(saturations, kQuantile) - kHueMargin);
  model.min_value_ = std::max(kMinValue, Quantile(values, kQuantile) / 4);  // in the shade
  model.max_value_ = 255;
  if (2 * wide > kBins) {
    lesson.state = TrainingState::kTooManyColours;
    return lesson;
  }
  cv::Mat weights;
  model.BackProject(bgr, weights);
  const int around = cv::countNonZero(mask == 0), alike = cv::countNonZero((weights > 127) & (mask == 0));
  lesson.state =
      around > 0 && 2 * alike > around ? TrainingState::kLikeSurroundings : TrainingState::kTrained;
  return lesson;
}

void ColourModel::BackProject(const cv::Mat& bgr, cv::Mat& weights) const {
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV_FULL);
  weights.create(bgr.size(), CV_8UC1);
  // The gates as tables: no branches for each pixel.
  std::array<std::uint8_t, 256> saturation{}, value{};
  for (int i = 0; i < 256; ++i) {
    saturation[static_cast<std::size_t>(i)] = i >= min_saturation_ ? 255 : 0;
    value[static_cast<std::size_t>(i)] = i >= min_value_ && i <= max_value_ ? 255 : 0;
  }
  for (int y = 0; y < hsv.rows; ++y) {
    const uchar* p = hsv.ptr<uchar>(y);
    uchar* w = weights.ptr<uchar>(y);
    for (int x = 0; x < hsv.cols; ++x, p += 3) w[x] = hue_[p[0]] & saturation[p[1]] & value[p[2]];
  }
}

double ColourModel::Matched(const cv::Mat& weights) {
  if (weights.empty()) return 0;
  return static_cast<double>(cv::countNonZero(weights > 127)) / static_cast<double>(weights.total());
}

}  // namespace kestrel::vision
