// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kestrel::vision {
namespace {

constexpr double kRim_px = 1e-3;  // more than the rounding of a float, so that no neighbour is missing

// The x of a whole row between 0 and cols at which all a x + c >= 0.
Patch::Span Within(const std::array<std::pair<double, double>, 5>& bounds, int cols) {
  double low = 0, high = cols - 1;
  for (const auto& [a, c] : bounds) {
    if (a > 0) {
      low = std::max(low, -c / a);
    } else if (a < 0) {
      high = std::min(high, -c / a);
    } else if (!(c >= 0)) {
      return {};
    }
  }
  if (!(low <= high)) return {};
  const int begin = static_cast<int>(std::ceil(low)), end = static_cast<int>(std::floor(high)) + 1;
  return begin < end ? Patch::Span{begin, end} : Patch::Span{};
}

}  // namespace

void Sample(const cv::Mat& image, const Eigen::Matrix3d& M, int cols, int rows, Patch& patch) {
  const std::size_t n = static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows);
  if (patch.grey.size() < n) patch.grey.resize(n);
  if (patch.u.size() < static_cast<std::size_t>(cols)) patch.u.resize(static_cast<std::size_t>(cols));
  if (patch.v.size() < static_cast<std::size_t>(cols)) patch.v.resize(static_cast<std::size_t>(cols));
  patch.spans.resize(static_cast<std::size_t>(rows));
  patch.cols = cols;
  patch.count = 0;
  const double right = image.cols - 1 - kRim_px, bottom = image.rows - 1 - kRim_px;
  const std::size_t stride = image.step1();
  const float* pixels = image.ptr<float>();
  const int last_u = image.cols - 2, last_v = image.rows - 2;
  float *u = patch.u.data(), *v = patch.v.data();
  for (int y = 0; y < rows; ++y) {
    const Eigen::Vector3d at = M.col(1) * y + M.col(2), by = M.col(0);
    const auto line = [&](double a, double b, double c) {
      return std::pair{a * by.x() + b * by.y() + c * by.z(), a * at.x() + b * at.y() + c * at.z()};
    };
    const double rim = kRim_px;
    Patch::Span& span = patch.spans[static_cast<std::size_t>(y)];
    std::array bounds{line(1, 0, -rim), line(0, 1, -rim), line(-1, 0, right), line(0, -1, bottom),
                      line(0, 0, 1)};
    bounds[4].second -= 1e-9;
    span = Within(bounds, cols);
    patch.count += span.end - span.begin;
    const float ax = static_cast<float>(at.x()), ay = static_cast<float>(at.y()),
                az = static_cast<float>(at.z());
    const float bx = static_cast<float>(by.x()), by_ = static_cast<float>(by.y()),
                bz = static_cast<float>(by.z());
    for (int x = span.begin; x < span.end; ++x) {
      const float fx = static_cast<float>(x);
      const float scale = 1 / (az + bz * fx);
      u[x] = (ax + bx * fx) * scale;
      v[x] = (ay + by_ * fx) * scale;
    }
    float* grey = patch.grey.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(cols);
    for (int x = span.begin; x < span.end; ++x) {
      // A warp that diverges is seen so obliquely that a float's rounding reaches over the rim.
      const int iu = std::clamp(static_cast<int>(u[x]), 0, last_u),
                iv = std::clamp(static_cast<int>(v[x]), 0, last_v);
      const float fu = u[x] - static_cast<float>(iu), fv = v[x] - static_cast<float>(iv);
      const float* p = pixels + static_cast<std::size_t>(iv) * stride + static_cast<std::size_t>(iu);
      const float upper = p[0] + fu * (p[1] - p[0]), lower = p[stride] + fu * (p[stride + 1] - p[stride]);
      grey[x] = upper + fv * (lower - upper);
    }
  }
}

void Differentiate(const Patch& patch, const TemplateLevel& level, PatchGradient& slope) {
  const int cols = level.cols, rows = level.rows;
  slope.gradient.resize(2, level.normal.cols());
  slope.spans.resize(static_cast<std::size_t>(rows));
  slope.count = 0;
  const float half = static_cast<float>(0.5 / level.normal_from_pixel(0, 0));
  for (int y = 0; y < rows; ++y) {
    Patch::Span& span = slope.spans[static_cast<std::size_t>(y)];
    span = {};
    if (y == 0 || y == rows - 1) continue;
    const Patch::Span *above = &patch.spans[static_cast<std::size_t>(y) - 1], *here = above + 1,
                      *below = above + 2;
    span.begin = std::max({above->begin, here->begin + 1, below->begin});
    span.end = std::max(span.begin, std::min({above->end, here->end - 1, below->end}));
    slope.count += span.end - span.begin;
    const float* grey = patch.grey.data() + static_cast<std::ptrdiff_t>(y) * cols;
    float *by_x = &slope.gradient(0, static_cast<Eigen::Index>(y) * cols),
          *by_y = &slope.gradient(1, static_cast<Eigen::Index>(y) * cols);
    for (int x = span.begin; x < span.end; ++x) {
      by_x[x] = half * (grey[x + 1] - grey[x - 1]);
      by_y[x] = half * (grey[x + cols] - grey[x - cols]);
    }
  }
}

}  // namespace kestrel::vision
