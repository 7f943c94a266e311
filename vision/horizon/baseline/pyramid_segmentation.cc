// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/baseline/pyramid_segmentation.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace kestrel::vision {
namespace {

struct Level {
  int width = 0, height = 0;
  std::vector<float> value;   // mean of what is linked to it
  std::vector<float> weight;  // pixels of the image below it
  std::vector<int> father;    // in the level above; -1: it begins a segment

  int At(int x, int y) const { return y * width + x; }
};

Level LevelOf(const cv::Mat& values) {
  Level level;
  level.width = values.cols, level.height = values.rows;
  level.value.assign(values.begin<float>(), values.end<float>());
  level.weight.assign(level.value.size(), 1);
  level.father.assign(level.value.size(), -1);
  return level;
}

void LinkToMostSimilar(Level& sons, const Level& fathers, double link_grey) {
  for (int y = 0; y < sons.height; ++y)
    for (int x = 0; x < sons.width; ++x) {
      const int i = sons.At(x, y);
      float least = static_cast<float>(link_grey);
      sons.father[i] = -1;
      for (const int fy : {(y - 1) >> 1, (y + 1) >> 1})
        for (const int fx : {(x - 1) >> 1, (x + 1) >> 1}) {
          if (fx < 0 || fy < 0 || fx >= fathers.width || fy >= fathers.height) continue;
          const int f = fathers.At(fx, fy);
          const float off = std::abs(sons.value[i] - fathers.value[f]);
          if (off < least) least = off, sons.father[i] = f;
        }
    }
}

// A father without sons keeps its value and weighs nothing.
void Average(const Level& sons, Level& fathers) {
  std::vector<double> sum(fathers.value.size(), 0), weight(fathers.value.size(), 0);
  for (std::size_t i = 0; i < sons.value.size(); ++i) {
    if (sons.father[i] < 0) continue;
    sum[sons.father[i]] += static_cast<double>(sons.weight[i]) * static_cast<double>(sons.value[i]);
    weight[sons.father[i]] += static_cast<double>(sons.weight[i]);
  }
  for (std::size_t f = 0; f < sum.size(); ++f) {
    if (weight[f] > 0) fathers.value[f] = static_cast<float>(sum[f] / weight[f]);
    fathers.weight[f] = static_cast<float>(weight[f]);
  }
}

// Segments in the order of their values, each joined to the ones before while it is near their mean.
void JoinAlike(std::vector<Level>& levels, double join_grey) {
  std::vector<std::pair<int, int>> roots;  // level, pixel
  for (int k = 0; k < static_cast<int>(levels.size()); ++k)
    for (int i = 0; i < static_cast<int>(levels[k].value.size()); ++i)
      if (levels[k].father[i] < 0 && levels[k].weight[i] > 0) roots.emplace_back(k, i);
  std::stable_sort(roots.begin(), roots.end(), [&](const auto& a, const auto& b) {
    return levels[a.first].value[a.second] < levels[b.first].value[b.second];
  });
  for (std::size_t first = 0; first < roots.size();) {
    double sum = 0, weight = 0;
    std::size_t last = first;
    for (; last < roots.size(); ++last) {
      const auto [k, i] = roots[last];
      const double value = static_cast<double>(levels[k].value[i]);
      if (weight > 0 && value - sum / weight >= join_grey) break;
      sum += static_cast<double>(levels[k].weight[i]) * value;
      weight += static_cast<double>(levels[k].weight[i]);
    }
    for (; first < last; ++first)
      levels[roots[first].first].value[roots[first].second] = static_cast<float>(sum / weight);
  }
}

}  // namespace

cv::Mat SegmentByPyramid(const cv::Mat& grey, const PyramidSegmentationOptions& options) {
  cv::Mat values;
  grey.convertTo(values, CV_32F);
  std::vector<Level> levels = {LevelOf(values)};
  for (int k = 0; k < options.levels && std::min(values.cols, values.rows) > 2; ++k) {
    cv::Mat above;
    cv::pyrDown(values, above);
    levels.push_back(LevelOf(above));
    values = above;
    for (int round = 0; round < options.rounds; ++round) {
      LinkToMostSimilar(levels[k], levels[k + 1], options.link_grey);
      Average(levels[k], levels[k + 1]);
    }
  }
  JoinAlike(levels, options.join_grey);
  for (int k = static_cast<int>(levels.size()) - 2; k >= 0; --k)
    for (std::size_t i = 0; i < levels[k].value.size(); ++i)
      if (const int f = levels[k].father[i]; f >= 0) levels[k].value[i] = levels[k + 1].value[f];
  cv::Mat out;
  cv::Mat(grey.rows, grey.cols, CV_32FC1, levels.front().value.data()).convertTo(out, CV_8U);
  return out;
}

}  // namespace kestrel::vision
