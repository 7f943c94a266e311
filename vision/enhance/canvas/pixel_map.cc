// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/pixel_map.h"

#include <algorithm>
#include <vector>

namespace kestrel::vision {
namespace {

struct Node {
  float u = PixelMap::kNowhere, v = PixelMap::kNowhere;
  bool somewhere() const { return u != PixelMap::kNowhere; }
};

// 0, step, 2 step, ... and the last.
std::vector<int> Steps(int length, int step) {
  std::vector<int> at;
  for (int i = 0; i < length - 1; i += step) at.push_back(i);
  at.push_back(length - 1);
  return at;
}

}  // namespace

PixelMap MakePixelMap(const cv::Rect& part, int step,
                      const std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>& source) {
  PixelMap map{cv::Mat(part.size(), CV_32FC1), cv::Mat(part.size(), CV_32FC1)};
  if (part.empty()) return map;
  const auto exact = [&](int x, int y) {
    const auto at = source({part.x + x, part.y + y});
    return at ? Node{static_cast<float>(at->x()), static_cast<float>(at->y())} : Node();
  };
  const std::vector<int> xs = Steps(part.width, step), ys = Steps(part.height, step);
  const auto row_of_nodes = [&](int y) {
    std::vector<Node> nodes;
    for (const int x : xs) nodes.push_back(exact(x, y));
    return nodes;
  };
  const auto write = [&](int x, int y, const Node& node) {
    map.u.at<float>(y, x) = node.u, map.v.at<float>(y, x) = node.v;
  };
  std::vector<Node> above = row_of_nodes(0), below;
  for (std::size_t k = 0; k < xs.size(); ++k) write(xs[k], 0, above[k]);
  for (std::size_t j = 0; j < ys.size(); ++j, above = below) {
    const int y0 = ys[j], y1 = j + 1 < ys.size() ? ys[j + 1] : y0;
    below = y1 > y0 ? row_of_nodes(y1) : above;
    for (std::size_t k = 0; k < xs.size(); ++k) {
      const int x0 = xs[k], x1 = k + 1 < xs.size() ? xs[k + 1] : x0;
      const std::size_t right = x1 > x0 ? k + 1 : k;
      const Node &a = above[k], &b = above[right], &c = below[k], &d = below[right];
      const bool whole = a.somewhere() && b.somewhere() && c.somewhere() && d.somewhere();
      for (int y = y0; y < std::max(y1, y0 + 1); ++y) {
        const float s = y1 > y0 ? static_cast<float>(y - y0) / static_cast<float>(y1 - y0) : 0;
        if (!whole) {
          for (int x = x0; x < std::max(x1, x0 + 1); ++x) write(x, y, exact(x, y));
          continue;
        }
        const float lu = a.u + s * (c.u - a.u), lv = a.v + s * (c.v - a.v);
        const float ru = b.u + s * (d.u - b.u), rv = b.v + s * (d.v - b.v);
        const float n = x1 > x0 ? 1.0F / static_cast<float>(x1 - x0) : 0, du = (ru - lu) * n,
                    dv = (rv - lv) * n;
        float *u = map.u.ptr<float>(y) + x0, *v = map.v.ptr<float>(y) + x0;
        for (int x = 0; x < std::max(x1 - x0, 1); ++x) {
          u[x] = lu + du * static_cast<float>(x);
          v[x] = lv + dv * static_cast<float>(x);
        }
      }
    }
  }
  return map;
}

}  // namespace kestrel::vision
