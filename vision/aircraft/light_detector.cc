// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/light_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

// Red, green and blue of a pure hue, less their mean, of length 1.
Eigen::Vector3d Direction(double hue_deg) {
  const auto channel = [&](double at_deg) {
    const double off = std::abs(std::remainder(hue_deg - at_deg, 360.0));
    return std::clamp(2 - off / 60, 0.0, 1.0);
  };
  Eigen::Vector3d rgb(channel(0), channel(120), channel(240));
  rgb.array() -= rgb.mean();
  return rgb.normalized();
}

// The centre of a spot's colour over its box and a ring of one pixel.
LightSpot Measure(const cv::Mat& component, const cv::Mat& labels, int label, const cv::Rect& box,
                  int colour) {
  const cv::Rect wider =
      cv::Rect(box.x - 1, box.y - 1, box.width + 2, box.height + 2) & cv::Rect({}, component.size());
  LightSpot spot{.colour = colour};
  double sum = 0;
  for (int y = wider.y; y < wider.br().y; ++y)
    for (int x = wider.x; x < wider.br().x; ++x) {
      const int owner = labels.at<int>(y, x);
      if (owner != 0 && owner != label) continue;  // a neighbour's
      spot.area_px += owner == label;
      const double weight = component.at<std::uint8_t>(y, x);
      sum += weight;
      spot.centre += weight * Eigen::Vector2d(x, y);
    }
  if (sum > 0) spot.centre /= sum;
  return spot;
}

}  // namespace

cv::Mat HueComponent(const cv::Mat& bgr, double hue_deg) {
  const Eigen::Vector3d d = Direction(hue_deg);
  // A pure colour at full brightness comes to 255.
  const double full = 255 * (d.cwiseMax(0.0)).sum();
  cv::Mat component;
  cv::transform(bgr, component, cv::Matx13d(d.z(), d.y(), d.x()) * (255 / full));
  return component;
}

std::vector<LightSpot> FindLights(const cv::Mat& bgr, const cv::Rect& within,
                                  const std::vector<ColourRange>& colours,
                                  const LightDetectorOptions& options) {
  std::vector<LightSpot> spots;
  const cv::Rect part = within & cv::Rect({}, bgr.size());
  if (part.width < 3 || part.height < 3) return spots;
  const cv::Mat image = bgr(part);
  cv::Mat weights, labels, stats, centroids;
  for (std::size_t c = 0; c < colours.size(); ++c) {
    ColourModel(colours[c]).BackProject(image, weights);
    const int count = cv::connectedComponentsWithStats(weights > 127, labels, stats, centroids, 8, CV_32S);
    if (count < 2) continue;
    const cv::Mat component = HueComponent(image, colours[c].hue_deg);
    std::vector<LightSpot> of_colour;
    for (int i = 1; i < count; ++i) {
      const int* s = stats.ptr<int>(i);
      const cv::Rect box(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH],
                         s[cv::CC_STAT_HEIGHT]);
      const int area = s[cv::CC_STAT_AREA];
      const bool at_border =
          box.x == 0 || box.y == 0 || box.br().x == part.width || box.br().y == part.height;
      const bool compact =
          std::max(box.width, box.height) <= 3 * std::min(box.width, box.height) && area >= 0.4 * box.area();
      if (at_border || !compact || area < options.min_area_px || area > options.max_area_px) continue;
      of_colour.push_back(Measure(component, labels, i, box, static_cast<int>(c) + 1));
      of_colour.back().centre += Eigen::Vector2d(part.x, part.y);
    }
    const auto larger = [](const LightSpot& a, const LightSpot& b) { return a.area_px > b.area_px; };
    std::stable_sort(of_colour.begin(), of_colour.end(), larger);
    if (std::ssize(of_colour) > options.max_spots)
      of_colour.resize(static_cast<std::size_t>(options.max_spots));
    spots.insert(spots.end(), of_colour.begin(), of_colour.end());
  }
  return spots;
}

}  // namespace kestrel::vision
