// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/template_level.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {
namespace {

// Of the differences of the neighbours; at the picture's rim of the pixel itself and its one neighbour.
float Slope(const cv::Mat& image, int x, int y, int dx, int dy) {
  const int x0 = std::max(x - dx, 0), x1 = std::min(x + dx, image.cols - 1);
  const int y0 = std::max(y - dy, 0), y1 = std::min(y + dy, image.rows - 1);
  return (image.at<float>(y1, x1) - image.at<float>(y0, x0)) / static_cast<float>(x1 - x0 + y1 - y0);
}

TemplateLevel MakeLevel(const cv::Mat& image, int level, const cv::Rect& region) {
  const int scale = 1 << level;
  const auto first = [&](int from) { return (from + scale - 1) / scale; };
  const int left = first(region.x), top = first(region.y);
  TemplateLevel t;
  t.level = level;
  t.cols = std::min((region.x + region.width - 1) / scale, image.cols - 1) - left + 1;
  t.rows = std::min((region.y + region.height - 1) / scale, image.rows - 1) - top + 1;
  const double half = std::max(region.width, region.height) / 2.0;  // px of level 0
  const Eigen::Vector2d centre(region.x + (region.width - 1) / 2.0, region.y + (region.height - 1) / 2.0);
  t.normal_from_pixel << scale / half, 0, (left * scale - centre.x()) / half,  //
      0, scale / half, (top * scale - centre.y()) / half, 0, 0, 1;

  const Eigen::Index n = static_cast<Eigen::Index>(t.cols) * t.rows;
  t.normal.resize(2, n), t.gradient.resize(2, n), t.design.resize(kDesignRows, n);
  const float per_normal = static_cast<float>(half / scale);
  double sum = 0, squares = 0;
  Eigen::Index i = 0;
  for (int y = 0; y < t.rows; ++y) {
    for (int x = 0; x < t.cols; ++x, ++i) {
      const float grey = image.at<float>(top + y, left + x);
      sum += grey, squares += static_cast<double>(grey) * grey;
      t.normal.col(i) = (t.normal_from_pixel * Eigen::Vector3d(x, y, 1)).head<2>().cast<float>();
      t.gradient.col(i) << per_normal * Slope(image, left + x, top + y, 1, 0),
          per_normal * Slope(image, left + x, top + y, 0, 1);
      t.design(kGainRow, i) = grey;
      t.design(kOffsetRow, i) = 1;
      t.design.block<8, 1>(kFirstWarpRow, i) = (t.gradient.col(i).cast<double>().transpose() *
                                                ExponentialDerivative(t.normal.col(i).cast<double>()))
                                                   .transpose()
                                                   .cast<float>();
    }
  }
  t.mean_grey = sum / static_cast<double>(n);
  t.variance = squares / static_cast<double>(n) - t.mean_grey * t.mean_grey;
  t.design.row(kGainRow).array() -= static_cast<float>(t.mean_grey);
  const Eigen::Matrix<double, kDesignRows, Eigen::Dynamic> exact = t.design.cast<double>();
  t.hessian = exact * exact.transpose();
  return t;
}

}  // namespace

std::vector<TemplateLevel> MakeTemplateLevels(const ImagePyramid& picture, const cv::Rect& region, int levels,
                                              int min_side_px) {
  std::vector<TemplateLevel> made;
  const int count = std::min(levels, static_cast<int>(picture.levels.size()));
  for (int level = 0; level < count; ++level) {
    if (level > 0 && std::min(region.width, region.height) >> level < min_side_px) break;
    made.push_back(MakeLevel(picture.levels[static_cast<std::size_t>(level)], level, region));
  }
  return made;
}

}  // namespace kestrel::vision
