// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/residual_weights.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/least_squares.h"

namespace kestrel::vision {
namespace {

constexpr double kMinSigma_grey = 0.7;       // less is rounding and interpolation
constexpr double kSigmaOverMedian = 1.4826;  // of a normal distribution
constexpr float kHuber = 1.345F, kTukey = 4.685F;
constexpr std::size_t kSample = 1500;  // pixels, evenly spread, whose median stands for that of all

}  // namespace

void WeighResiduals(const TemplateLevel& level, const Patch& patch, const Light& light, AlignmentLoss loss,
                    ResidualWeights& all) {
  const float gain = static_cast<float>(light.gain), offset = static_cast<float>(light.offset);
  const std::size_t n = static_cast<std::size_t>(level.design.cols());
  if (all.weights.size() < n) all.weights.resize(n);
  const auto for_each = [&](const auto& visit) {
    for (int y = 0; y < level.rows; ++y) {
      const Patch::Span span = patch.spans[static_cast<std::size_t>(y)];
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(level.cols);
      for (int x = span.begin; x < span.end; ++x) visit(row + static_cast<std::size_t>(x));
    }
  };
  const float* centred = level.design.row(kGainRow).data();
  const std::size_t every = static_cast<std::size_t>(patch.count) / kSample + 1;
  std::size_t k = 0;
  all.sample.clear();
  for_each([&](std::size_t i) {
    const float residual = patch.grey[i] - gain * centred[i] - offset;
    all.weights[i] = residual;
    if (k++ % every == 0) all.sample.push_back(std::abs(residual));
  });
  if (all.sample.empty()) return;
  const auto middle = all.sample.begin() + static_cast<std::ptrdiff_t>(all.sample.size() / 2);
  std::nth_element(all.sample.begin(), middle, all.sample.end());
  all.sigma_grey = std::max(kSigmaOverMedian * static_cast<double>(*middle), kMinSigma_grey);
  const float sigma = static_cast<float>(all.sigma_grey);
  if (loss == AlignmentLoss::kTukey) {
    for_each([&](std::size_t i) { all.weights[i] = TukeyWeight(all.weights[i] / (kTukey * sigma)); });
  } else {
    for_each([&](std::size_t i) {
      const float size = std::abs(all.weights[i]);
      all.weights[i] = size > kHuber * sigma ? kHuber * sigma / size : 1;
    });
  }
}

}  // namespace kestrel::vision
