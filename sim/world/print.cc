// SPDX-License-Identifier: Apache-2.0
#include "sim/world/print.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/random.h"

namespace kestrel::sim {
namespace {

constexpr double kPenumbra_m = 0.03;
constexpr double kBlot_m = 0.12;
constexpr double kEdge = 0.1;  // of a blot, of the deviation of what it is drawn from
// Water fills the pores of paper and cloth, which then give back less light, and its face some of the sky's.
constexpr float kWetLight = 0.55f, kSkyInIt = 14;

// From 0 to 1 while the value goes from below to above 0 by half the width.
float Step(double value, double width) {
  const double t = std::clamp(value / width + 0.5, 0.0, 1.0);
  return static_cast<float>(t * t * (3 - 2 * t));
}

// at: the share of a change, of each pixel: light is multiplied by a share and increased.
void Blend(cv::Mat& picture, const cv::Mat& at, float light, float more) {
  const int channels = picture.channels();
  for (int y = 0; y < picture.rows; ++y) {
    float* row = picture.ptr<float>(y);
    for (int x = 0; x < picture.cols; ++x)
      for (int c = 0; c < channels; ++c, ++row) {
        const float share = at.at<float>(y, x);
        *row += share * ((light - 1) * *row + more);
      }
  }
}

void ShadeOneSide(cv::Mat& picture, const Eigen::Vector2d& size_m, const PrintParameters& print,
                  std::uint64_t seed) {
  const double towards = RandomStream(seed, "print shade").Uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector2d n(std::cos(towards), std::sin(towards));
  std::vector<double> along;
  along.reserve(picture.total());
  cv::Mat at(picture.size(), CV_32FC1);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      along.push_back(n.dot(
          Eigen::Vector2d((y + 0.5) / picture.rows * size_m.x(), (x + 0.5) / picture.cols * size_m.y())));
  std::vector<double> sorted = along;
  const auto edge =
      sorted.begin() + static_cast<std::ptrdiff_t>(print.shade * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), edge, sorted.end());
  for (std::size_t i = 0; i < along.size(); ++i)
    at.ptr<float>()[i] = Step(*edge - along[i] + (print.shade < 1 ? 0 : kPenumbra_m), kPenumbra_m);
  Blend(picture, at, static_cast<float>(print.shade_light), 0);
}

void Wet(cv::Mat& picture, const Eigen::Vector2d& size_m, double share, std::uint64_t seed) {
  const auto blots = [](double length_m) {
    return std::max(3, static_cast<int>(std::lround(length_m / kBlot_m)));
  };
  cv::Mat noise(blots(size_m.x()), blots(size_m.y()), CV_32FC1);
  cv::RNG random(RandomStream(seed, "print wet").Bits() | 1);
  random.fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::resize(noise, noise, picture.size(), 0, 0, cv::INTER_CUBIC);
  std::vector<float> sorted(noise.begin<float>(), noise.end<float>());
  const auto edge =
      sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), edge, sorted.end());
  const float level = *edge;
  for (float& each : cv::Mat_<float>(noise)) each = Step(level - each + (share < 1 ? 0 : kEdge), kEdge);
  Blend(picture, noise, kWetLight, kSkyInIt);
}

}  // namespace

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
  if (print.wet > 0) Wet(inked, size_m, print.wet, seed);
  if (print.shade > 0) ShadeOneSide(inked, size_m, print, seed);
  cv::Mat printed;
  inked.convertTo(printed, CV_8U);
  return printed;
}

}  // namespace kestrel::sim
