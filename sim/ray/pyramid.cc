// SPDX-License-Identifier: Apache-2.0
#include "sim/ray/pyramid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::ray {
namespace {

// Writes one level with its border.
void Store(const cv::Mat& rgb, bool repeats, std::uint32_t* origin, int stride) {
  const auto inside = [&](int i, int n) { return repeats ? (i + n) % n : std::clamp(i, 0, n - 1); };
  for (int y = -1; y <= rgb.rows; ++y) {
    for (int x = -1; x <= rgb.cols; ++x) {
      const auto& texel = rgb.at<cv::Vec3b>(inside(y, rgb.rows), inside(x, rgb.cols));
      origin[static_cast<std::ptrdiff_t>(y) * stride + x] =
          static_cast<std::uint32_t>(texel[2] | texel[1] << 8 | texel[0] << 16);
    }
  }
}

// The picture at another size, its larger neighbour's texels between its own.
cv::Mat Enlarged(const cv::Mat& small, cv::Size size, bool repeats) {
  const cv::Size2d ratio(static_cast<double>(small.cols) / size.width,
                         static_cast<double>(small.rows) / size.height);
  cv::Mat x(size, CV_32F), y(size, CV_32F), large;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      x.at<float>(v, u) = static_cast<float>((u + 0.5) * ratio.width - 0.5);
      y.at<float>(v, u) = static_cast<float>((v + 0.5) * ratio.height - 0.5);
    }
  }
  cv::remap(small, large, x, y, cv::INTER_LINEAR, repeats ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
  return large;
}

// log2 of the footprint in the middle of each of the four parts of an octave.
constexpr double kMiddles[4] = {0.146, 0.396, 0.646, 0.896};

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

  std::vector<cv::Size> octaves = {{width, height}};
  while (octaves.back() != cv::Size(1, 1))
    octaves.emplace_back(std::max(1, octaves.back().width / 2), std::max(1, octaves.back().height / 2));
  p.levels = 4 * static_cast<int>(octaves.size() - 1) + 2;
  std::int32_t total = 0;
  for (int l = 0; l < p.levels; ++l) {
    const cv::Size size = octaves[l == 0 ? 0 : (l - 1) / 4];
    p.width[l] = static_cast<float>(size.width);
    p.height[l] = static_cast<float>(size.height);
    p.stride[l] = size.width + 2;
    p.offset[l] = total + p.stride[l] + 1;
    total += (size.width + 2) * (size.height + 2);
  }
  p.face_stride = p.faces == 6 ? total : 0;
  p.texels.assign(static_cast<std::size_t>(total) * p.faces + 1, 0);  // the last is read with one more
  for (int face = 0; face < p.faces; ++face) {
    const auto store = [&](const cv::Mat& rgb, int level) {
      Store(rgb, !cube, p.texels.data() + p.offset[level] + static_cast<std::ptrdiff_t>(face) * p.face_stride,
            p.stride[level]);
    };
    cv::Mat rgb(height, width, CV_8UC3, data + static_cast<std::size_t>(face) * 3 * width * width);
    store(rgb, 0);
    for (std::size_t octave = 0; octave + 1 < octaves.size(); ++octave) {
      cv::Mat half, mixed;
      cv::resize(rgb, half, octaves[octave + 1], 0, 0, cv::INTER_AREA);
      const cv::Mat blurred = Enlarged(half, rgb.size(), !cube);
      for (int part = 0; part < 4; ++part) {
        cv::addWeighted(rgb, 1 - kMiddles[part], blurred, kMiddles[part], 0, mixed);
        store(mixed, 1 + 4 * static_cast<int>(octave) + part);
      }
      rgb = half;
    }
    store(rgb, p.levels - 1);
  }
  return p;
}

}  // namespace kestrel::ray
