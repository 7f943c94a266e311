// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/camera/camera_model.h"

// Skies and grounds painted ray by ray, independent of any renderer: every pixel asks what lies in its
// direction.
namespace kestrel::vision {

struct PaintedWorld {
  Eigen::Vector3d zenith{150, 95, 50}, horizon{215, 200, 185};  // blue, green, red
  Eigen::Vector3d ground{60, 95, 85}, ground_far{120, 130, 125};
  double ground_rough = 22, cloud = 0;  // grey levels
  double haze_m = 15000;                // over which the ground fades to its far colour
  double dip = 0;                       // rad
  std::optional<Eigen::Vector3d> sun_N;
  std::function<double(double)> hills;         // elevation over the horizon by azimuth, rad
  std::function<bool(double azimuth)> hidden;  // by the aircraft itself: black
  double noise = 1.5;
  Eigen::Vector3d position_N{0, 0, -60};
};

// Smooth noise of unit size on a lattice of cells.
inline double LatticeNoise(double x, double y, std::uint32_t seed) {
  const auto at = [&](int i, int j) {
    std::uint32_t h = static_cast<std::uint32_t>(i) * 374761393u +
                      static_cast<std::uint32_t>(j) * 668265263u + seed * 2246822519u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return static_cast<double>((h ^ (h >> 16)) & 0xffff) / 32768.0 - 1;
  };
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double u = x - i, v = y - j, a = u * u * (3 - 2 * u), b = v * v * (3 - 2 * v);
  return (1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) +
         b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1));
}

class SkylinePhotographer {
 public:
  explicit SkylinePhotographer(const CameraModel& camera) : camera_(camera) {
    for (int y = 0; y < HeightPx(camera); ++y)
      for (int x = 0; x < WidthPx(camera); ++x) {
        const auto ray = Ray(camera, {x, y});
        const auto next = Ray(camera, {x + 0.5, y + 0.5});
        rays_.push_back(ray ? *ray : Eigen::Vector3d::Zero());
        widths_.push_back(ray && next ? 1.4 * (*ray - *next).norm() : 0);  // about a pixel
      }
  }

  cv::Mat Paint(const PaintedWorld& w, const Eigen::Matrix3d& R_NC, int seed) const {
    cv::Mat image(HeightPx(camera_), WidthPx(camera_), CV_8UC3);
    cv::RNG rng(static_cast<std::uint64_t>(seed) * 77 + 5);
    cv::Mat noise(image.size(), CV_32FC3);
    rng.fill(noise, cv::RNG::NORMAL, 0, w.noise);
    std::size_t at = 0;
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x, ++at) {
        Eigen::Vector3d c = Eigen::Vector3d::Zero();
        if (!rays_[at].isZero()) c = Colour(w, R_NC * rays_[at], widths_[at]);
        for (int k = 0; k < 3; ++k)
          image.at<cv::Vec3b>(y, x)[k] =
              cv::saturate_cast<uchar>(c[k] + (rays_[at].isZero() ? 0.0f : noise.at<cv::Vec3f>(y, x)[k]));
      }
    return image;
  }

 private:
  static Eigen::Vector3d Colour(const PaintedWorld& w, const Eigen::Vector3d& ray_N, double width) {
    const double azimuth = std::atan2(ray_N.y(), ray_N.x()),
                 elevation = -std::asin(std::clamp(ray_N.z(), -1.0, 1.0));
    if (w.hidden && w.hidden(azimuth)) return {12, 12, 12};
    const double horizon = -w.dip, top = horizon + (w.hills ? w.hills(azimuth) : 0);
    const double share = std::clamp(0.5 + (elevation - top) / width, 0.0, 1.0);  // of the pixel that is sky
    Eigen::Vector3d sky = Eigen::Vector3d::Zero(), ground = Eigen::Vector3d::Zero();
    if (share > 0) {
      const double up = std::max(0.0, std::sin(elevation));
      sky = w.horizon + (w.zenith - w.horizon) * std::sqrt(up);
      if (w.cloud > 0) {
        const double s = 1 / (up + 0.15);
        const double n = LatticeNoise(2 * s * ray_N.x(), 2 * s * ray_N.y(), 7) +
                         0.5 * LatticeNoise(5 * s * ray_N.x(), 5 * s * ray_N.y(), 8);
        sky.array() += w.cloud * n;
      }
      if (w.sun_N) {
        const double c = w.sun_N->normalized().dot(ray_N);
        sky.array() += 900 * std::exp((c - 1) / 0.0008) + 110 * std::exp((c - 1) / 0.03);
      }
    }
    if (share < 1) {
      const bool hill = elevation > horizon - 1e-9;
      const double depression = std::max(1e-3, std::sin(-elevation + horizon));
      const double range = hill ? 4000 : std::min(-w.position_N.z() / depression, 3e4);
      const double fade = std::exp(-range / w.haze_m);
      const double reach = hill ? 4000 : range;
      const Eigen::Vector2d p = w.position_N.head<2>() + reach * ray_N.head<2>();
      double n = 0;
      for (const double size : {2.0, 12.0, 70.0, 400.0}) {
        const double blur = range * width / std::max(depression, hill ? 0.3 : 0.0);  // m per pixel
        n += LatticeNoise(p.x() / size, p.y() / size, static_cast<std::uint32_t>(size)) / (1 + blur / size);
      }
      ground = w.ground_far +
               fade * (w.ground + Eigen::Vector3d(0.6, 0.9, 1.0) * w.ground_rough * n - w.ground_far);
    }
    return share * sky + (1 - share) * ground;
  }

  CameraModel camera_;
  std::vector<Eigen::Vector3d> rays_;
  std::vector<double> widths_;
};

// R_BC of a camera that looks forward along the aircraft (z of C along x of B), or down (z along z, the top
// of the image forward).
inline Eigen::Matrix3d LooksForward() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return R;
}
inline Eigen::Matrix3d LooksDown() {
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return R;
}

}  // namespace kestrel::vision
