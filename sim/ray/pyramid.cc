// SPDX-License-Identifier: Apache-2.0
#include "sim/ray/pyramid.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace kestrel::ray {
namespace {

// Writes one level with its border.
void Store(const cv::Mat& rgb, bool repeats, std::uint64_t* origin, int stride) {
  const auto wrap = [&](int i, int n) { return repeats ? (i + n) % n : std::clamp(i, 0, n - 1); };
  const auto channel = [&](int x, int y, int c) -> std::uint64_t {
    return rgb.at<cv::Vec3b>(wrap(y, rgb.rows), wrap(x, rgb.cols))[c];
  };
  for (int y = -1; y <= rgb.rows; ++y) {
    for (int x = -1; x <= rgb.cols; ++x) {
      std::uint64_t pair = 0;
      for (int c = 0; c < 3; ++c) {
        pair |= (channel(x, y, 2 - c) | channel(x + 1, y, 2 - c) << 8) << (16 * c);
      }
      origin[static_cast<std::ptrdiff_t>(y) * stride + x] = pair;
    }
  }
}

}  // namespace

Pyramid MakePyramid(const mjModel* model, int texture) {
  Pyramid p;
  const int type = model->tex_type[texture];
  const int width = model->tex_width[texture];
  const int rows = model->tex_height[texture];
  mjtByte* data = model->tex_rgb + model->tex_adr[texture];
  const bool cube = type != mjTEXTURE_2D;
  const int height = cube ? width : rows;
  // A cube of one picture shows it on all sides.
  p.faces = cube && rows != width ? 6 : 1;

  std::int32_t total = 0;
  for (int w = width, h = height; p.levels < Pyramid::kMostLevels;
       w = std::max(1, w / 2), h = std::max(1, h / 2)) {
    const int l = p.levels++;
    p.width[l] = static_cast<float>(w);
    p.height[l] = static_cast<float>(h);
    p.stride[l] = w + 2;
    p.offset[l] = total + p.stride[l] + 1;
    total += (w + 2) * (h + 2);
    if (w == 1 && h == 1) break;
  }
  p.face_stride = p.faces == 6 ? total : 0;
  p.texels.assign(static_cast<std::size_t>(total) * p.faces, 0);
  for (int face = 0; face < p.faces; ++face) {
    cv::Mat rgb =
        cv::Mat(height, width, CV_8UC3, data + static_cast<std::size_t>(face) * 3 * width * width).clone();
    for (int l = 0; l < p.levels; ++l) {
      if (l > 0) {
        cv::Mat half;
        cv::resize(rgb, half, {static_cast<int>(p.width[l]), static_cast<int>(p.height[l])}, 0, 0,
                   cv::INTER_AREA);
        rgb = half;
      }
      Store(rgb, !cube, p.texels.data() + p.offset[l] + static_cast<std::ptrdiff_t>(face) * p.face_stride,
            p.stride[l]);
    }
  }
  return p;
}

}  // namespace kestrel::ray
