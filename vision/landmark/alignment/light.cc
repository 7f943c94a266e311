// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/light.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {
namespace {

// Weighted sums of the template's grey t and the patch's p.
struct Sums {
  double w = 0, t = 0, p = 0, tt = 0, tp = 0, pp = 0;
};

Sums SumGreys(const TemplateLevel& level, const Patch& patch, const float* weights) {
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  Sums s;
  for (int y = 0; y < level.rows; ++y) {
    const Patch::Span span = patch.spans[static_cast<std::size_t>(y)];
    const Eigen::Index n = span.end - span.begin;
    if (n == 0) continue;
    const Eigen::Index at = static_cast<Eigen::Index>(y) * level.cols + span.begin;
    const Row t(&level.design(kGainRow, at), n), p(patch.grey.data() + at, n);
    const auto add = [&](const auto& w) {
      s.t += static_cast<double>((w * t).sum()), s.p += static_cast<double>((w * p).sum());
      s.tt += static_cast<double>((w * t * t).sum()), s.tp += static_cast<double>((w * t * p).sum());
      s.pp += static_cast<double>((w * p * p).sum());
    };
    if (weights) {
      const Row w(weights + at, n);
      s.w += static_cast<double>(w.sum());
      add(w);
    } else {
      s.w += static_cast<double>(n);
      add(1.0F);
    }
  }
  return s;
}

Light FromSums(const Sums& s) {
  constexpr double kFlat_grey2 = 1e-6;  // no contrast at all
  const double flat = kFlat_grey2 * s.w;
  const double tt = std::max(s.tt - s.t * s.t / s.w, flat), pp = std::max(s.pp - s.p * s.p / s.w, flat);
  const double tp = s.tp - s.t * s.p / s.w;
  Light light;
  light.gain = tp / tt;
  light.offset = (s.p - light.gain * s.t) / s.w;
  light.contrast = std::sqrt(pp / tt);
  light.correlation = tp / std::sqrt(tt * pp);
  light.rms_grey = std::sqrt(std::max(pp - tp * tp / tt, 0.0) / s.w);
  light.weight = s.w;
  return light;
}

}  // namespace

Light FitLight(const TemplateLevel& level, const Patch& patch, const float* weights) {
  return FromSums(SumGreys(level, patch, weights));
}

Light SameLight(const TemplateLevel& level, const Patch& patch, const float* weights) {
  const Sums s = SumGreys(level, patch, weights);
  Light light = FromSums(s);
  light.gain = 1, light.offset = level.mean_grey;
  const double m = light.offset;
  const double squares = s.pp - 2 * (s.tp + m * s.p) + s.tt + 2 * m * s.t + m * m * s.w;
  light.rms_grey = std::sqrt(std::max(squares, 0.0) / s.w);
  return light;
}

}  // namespace kestrel::vision
