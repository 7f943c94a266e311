// SPDX-License-Identifier: Apache-2.0
#include "vision/sky_mask.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "vision/skyline_profile.h"

namespace kestrel {

namespace {

constexpr int kReduction = 4;
constexpr double kLowest = Radians(-6), kHighest = Radians(22), kStep = Radians(0.7);
constexpr int kAzimuths = 288;
constexpr int kReach = 2;  // azimuths to either side whose contour counts: a tree is narrower than its mask
constexpr int kFar = 12;   // azimuths, over which a contour that is not seen is taken from its neighbours

// The contour's elevation by azimuth: the highest of what is near.
std::vector<double> Heights(const std::vector<ProfilePoint>& points, double unknown) {
  const int n = static_cast<int>(points.size());
  std::vector<double> heights(points.size());
  for (int i = 0; i < n; ++i) {
    bool known = false;
    double highest = 0;
    for (int reach = kReach; !known && reach <= kFar; reach += kReach)
      for (int d = -reach; d <= reach; ++d) {
        const ProfilePoint& p = points[static_cast<std::size_t>((i + d + n) % n)];
        if (!p.found) continue;
        highest = known ? std::max(highest, p.elevation) : p.elevation;
        known = true;
      }
    heights[static_cast<std::size_t>(i)] = known ? std::max(highest, -unknown) : unknown;
  }
  return heights;
}

}  // namespace

SkyMask::SkyMask(const CameraModel& camera, const cv::Mat& forbidden)
    : sampler_(camera, forbidden), half_(WidthPx(camera) / 2, HeightPx(camera) / 2) {
  for (int y = 0; y < half_.height; ++y)
    for (int x = 0; x < half_.width; ++x) {
      const auto ray = Ray(camera, {2 * x + 0.5, 2 * y + 0.5});
      const bool own = !forbidden.empty() && cv::countNonZero(forbidden(cv::Rect(2 * x, 2 * y, 2, 2))) > 0;
      rays_.push_back(ray && !own ? Eigen::Vector3f(ray->cast<float>())
                                  : Eigen::Vector3f(Eigen::Vector3f::Zero()));
    }
}

cv::Mat SkyMask::Find(const cv::Mat& quarter, const Eigen::Vector3d& down_C, double down_sigma,
                      double margin) const {
  const Horizontal horizontal = HorizontalAbout(down_C, Eigen::Vector3d::UnitZ());
  const BandGrid grid{kAzimuths, static_cast<int>((kHighest - kLowest) / kStep) + 1, kLowest, kStep};
  const BandSamples band = sampler_.Read(quarter, kReduction, horizontal, grid);
  const std::vector<ProfilePoint> points = FindContour(band, grid, std::vector<double>(kAzimuths, 0.0),
                                                       {std::max(0.02, down_sigma), 0.09, 0.2, 2});
  const std::vector<double> heights = Heights(points, 2 * down_sigma);
  std::vector<float> limits;  // of the sine of the elevation
  for (const double h : heights) limits.push_back(static_cast<float>(std::sin(h + margin)));
  const auto [least, most] = std::minmax_element(limits.begin(), limits.end());
  const Eigen::Vector3f down = horizontal.down.cast<float>(), forward = horizontal.forward.cast<float>(),
                        right = horizontal.right.cast<float>();
  cv::Mat sky(half_, CV_8UC1);
  const Eigen::Vector3f* ray = rays_.data();
  for (int y = 0; y < half_.height; ++y) {
    auto* row = sky.ptr<uchar>(y);
    for (int x = 0; x < half_.width; ++x, ++ray) {
      const float up = -down.dot(*ray);
      bool above = up > *most;
      if (!above && up > *least && !ray->isZero()) {
        const float azimuth = cv::fastAtan2(right.dot(*ray), forward.dot(*ray));  // 0 to 360 degrees
        const int i = static_cast<int>(azimuth * (kAzimuths / 360.0f) + 0.5f) % kAzimuths;
        above = up > limits[static_cast<std::size_t>(i)];
      }
      row[x] = above && !ray->isZero() ? 255 : 0;
    }
  }
  return sky;
}

}  // namespace kestrel
