// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/sky_mask.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/tait_bryan.h"
#include "vision/horizon/skyline_profile.h"

namespace kestrel::vision {

namespace {

constexpr int kReduction = 4;
constexpr double kLowest = Radians(-6), kHighest = Radians(22), kStep = Radians(0.7);
constexpr int kAzimuths = 288;
constexpr double kEdge = Radians(0.3);  // above the contour, as wide as the contour is blurred
constexpr int kReach = 4;               // azimuths to either side, of which the middle height counts
constexpr int kFar = 12;  // azimuths, over which a contour that is not seen is taken from its neighbours

// The contour's elevation by azimuth: there, and the highest of what is near.
struct MaskContour {
  std::vector<double> here, near;
};
MaskContour ContourOf(const std::vector<ProfilePoint>& points, double unknown) {
  const int n = static_cast<int>(points.size());
  const auto around = [&](int i, int reach) {
    std::vector<double> heights;
    for (int d = -reach; d <= reach; ++d)
      if (const ProfilePoint& p = points[static_cast<std::size_t>((i + d + n) % n)]; p.found)
        heights.push_back(p.elevation);
    return heights;
  };
  // What stands up from its neighbours alone may be before the sky, with haze between it and the ground; if
  // it is a tree, it will be found to hang together with the ground.
  std::vector<double> usual;
  for (int i = 0; i < n; ++i) {
    std::vector<double> heights;
    for (int reach = kReach; heights.empty() && reach <= kFar; reach += kReach) heights = around(i, reach);
    if (heights.empty()) {
      usual.push_back(unknown);
      continue;
    }
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    usual.push_back(std::max(*middle, -unknown));
  }
  MaskContour contour;
  for (int i = 0; i < n; ++i) {
    double near = usual[static_cast<std::size_t>(i)];
    for (const int d : {-1, 1}) near = std::max(near, usual[static_cast<std::size_t>((i + d + n) % n)]);
    contour.near.push_back(near);
    contour.here.push_back(usual[static_cast<std::size_t>(i)]);
  }
  return contour;
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
  const MaskContour contour = ContourOf(points, 2 * down_sigma);
  std::vector<float> here, free;  // sines
  for (std::size_t i = 0; i < points.size(); ++i) {
    here.push_back(static_cast<float>(std::sin(contour.here[i] + kEdge)));
    free.push_back(static_cast<float>(std::sin(std::max(contour.here[i] + kEdge, contour.near[i] + margin))));
  }
  const float least = *std::min_element(here.begin(), here.end());
  const float most = *std::max_element(free.begin(), free.end());
  const Eigen::Vector3f down = horizontal.down.cast<float>(), forward = horizontal.forward.cast<float>(),
                        right = horizontal.right.cast<float>();
  cv::Mat sky(half_, CV_8UC1);
  const Eigen::Vector3f* ray = rays_.data();
  for (int y = 0; y < half_.height; ++y) {
    auto* row = sky.ptr<uchar>(y);
    for (int x = 0; x < half_.width; ++x, ++ray) {
      const float up = -down.dot(*ray);
      SkyZone zone = up > most ? kFreeSky : kNoSky;
      if (!zone && up > least && !ray->isZero()) {
        const float azimuth = cv::fastAtan2(right.dot(*ray), forward.dot(*ray));  // 0 to 360 degrees
        const auto i = static_cast<std::size_t>(azimuth * (kAzimuths / 360.0f) + 0.5f) % kAzimuths;
        zone = up > free[i] ? kFreeSky : up > here[i] ? kNearGround : kNoSky;
      }
      row[x] = ray->isZero() ? kNoSky : zone;
    }
  }
  return sky;
}

}  // namespace kestrel::vision
