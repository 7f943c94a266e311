// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/blending.h"

#include <algorithm>

namespace kestrel::vision {
namespace {

// Off the image: beyond the centres of its outermost pixels, where nothing is to be interpolated.
template <typename Weight>
void Fill(cv::Size image, const PixelMap& map, cv::Mat& weights, const Weight& weight) {
  constexpr float kRounded = 1e-3F;  // px, in the map, or a rim would be lost where pixels lie on pixels
  const auto right = static_cast<float>(image.width - 1) + kRounded,
             bottom = static_cast<float>(image.height - 1) + kRounded;
  for (int y = 0; y < weights.rows; ++y) {
    const float *u = map.u.ptr<float>(y), *v = map.v.ptr<float>(y);
    float* w = weights.ptr<float>(y);
    for (int x = 0; x < weights.cols; ++x) {
      const bool in = u[x] >= -kRounded && v[x] >= -kRounded && u[x] <= right && v[x] <= bottom;
      w[x] = in ? weight(u[x], v[x]) : 0.0F;
    }
  }
}

// Of the rim itself, so that a mosaic ends where its images do and not a pixel before.
constexpr float kLeast = 1e-4F;

struct Middle {
  float u, v, x, y;  // px; one over half the sides
  explicit Middle(cv::Size image)
      : u(static_cast<float>(image.width - 1) / 2),
        v(static_cast<float>(image.height - 1) / 2),
        x(2.0F / static_cast<float>(image.width)),
        y(2.0F / static_cast<float>(image.height)) {}
};

float Feather(const Middle& m, float u, float v) {
  const float x = (u - m.u) * m.x, y = (v - m.v) * m.y;
  return std::max((1 - x * x) * (1 - y * y), kLeast);
}

float Nearest(const Middle& m, float corner, float u, float v) {
  const float x = u - m.u, y = v - m.v;
  return std::max(1 - (x * x + y * y) * corner, kLeast);
}

float OfCorner(cv::Size image) {
  return 4.0F / static_cast<float>(image.width * image.width + image.height * image.height);
}

}  // namespace

double BlendWeight(Blending blending, cv::Size image, double u, double v) {
  if (!(u >= 0 && v >= 0 && u <= image.width - 1 && v <= image.height - 1)) return 0;
  const auto fu = static_cast<float>(u), fv = static_cast<float>(v);
  switch (blending) {
    case Blending::kAverage:
      return 1;
    case Blending::kFeather:
      return Feather(Middle(image), fu, fv);
    case Blending::kNearest:
      return Nearest(Middle(image), OfCorner(image), fu, fv);
  }
  return 0;
}

cv::Mat BlendWeights(Blending blending, cv::Size image, const PixelMap& map) {
  cv::Mat weights(map.u.size(), CV_32FC1);
  const Middle m(image);
  const float corner = OfCorner(image);
  switch (blending) {
    case Blending::kAverage:
      Fill(image, map, weights, [](float, float) { return 1.0F; });
      break;
    case Blending::kFeather:
      Fill(image, map, weights, [m](float u, float v) { return Feather(m, u, v); });
      break;
    case Blending::kNearest:
      Fill(image, map, weights, [m, corner](float u, float v) { return Nearest(m, corner, u, v); });
      break;
  }
  return weights;
}

}  // namespace kestrel::vision
