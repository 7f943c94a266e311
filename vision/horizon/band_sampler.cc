// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/band_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace kestrel::vision {

namespace {

constexpr double kKnot = 0.045;  // rad between the knots of the projected lattice, about

int StepsPerKnot(double step) { return std::clamp(static_cast<int>(kKnot / step), 1, 16); }

}  // namespace

Eigen::Vector3d Horizontal::Direction(double azimuth, double elevation) const {
  return std::cos(elevation) * (std::cos(azimuth) * forward + std::sin(azimuth) * right) -
         std::sin(elevation) * down;
}
double Horizontal::Azimuth(const Eigen::Vector3d& ray_C) const {
  return std::atan2(right.dot(ray_C), forward.dot(ray_C));
}
double Horizontal::Elevation(const Eigen::Vector3d& ray_C) const {
  return -std::asin(std::clamp(down.dot(ray_C), -1.0, 1.0));
}

Horizontal HorizontalAbout(const Eigen::Vector3d& down_C, const Eigen::Vector3d& forward_hint_C) {
  Horizontal h;
  h.down = down_C.normalized();
  const Eigen::Vector3d across = forward_hint_C - forward_hint_C.dot(h.down) * h.down;
  h.forward = across.norm() > 1e-9 ? Eigen::Vector3d(across.normalized()) : h.down.unitOrthogonal();
  h.right = h.down.cross(h.forward);
  return h;
}

BandSampler::BandSampler(CameraModel camera, cv::Mat forbidden)
    : camera_(std::move(camera)), forbidden_(std::move(forbidden)) {}

BandSamples BandSampler::Read(const cv::Mat& image, int reduction, const Horizontal& h,
                              const BandGrid& grid) const {
  const int per_azimuth = StepsPerKnot(2 * M_PI / grid.azimuths), per_elevation = StepsPerKnot(grid.step);
  const int na = (grid.azimuths + per_azimuth - 1) / per_azimuth + 1;
  const int ne = (grid.elevations - 1 + per_elevation - 1) / per_elevation + 1;
  // Knots in pixels of the reduced image; NaN where the lens shows nothing.
  std::vector<Eigen::Vector2f> knots(static_cast<std::size_t>(na * ne));
  std::vector<std::pair<double, double>> circle(static_cast<std::size_t>(ne));
  for (int j = 0; j < ne; ++j) {
    const double elevation = grid.Elevation(j * per_elevation);
    circle[static_cast<std::size_t>(j)] = {std::cos(elevation), std::sin(elevation)};
  }
  std::visit(
      [&](const auto& camera) {
        for (int i = 0; i < na; ++i) {
          const double azimuth = grid.Azimuth(i * per_azimuth);
          const Eigen::Vector3d level = std::cos(azimuth) * h.forward + std::sin(azimuth) * h.right;
          for (int j = 0; j < ne; ++j) {
            const auto [c, s] = circle[static_cast<std::size_t>(j)];
            const auto uv = camera.Project(c * level - s * h.down);
            knots[static_cast<std::size_t>(i * ne + j)] =
                uv ? Eigen::Vector2f(((uv->array() + 0.5) / reduction - 0.5).matrix().template cast<float>())
                   : Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
          }
        }
      },
      camera_);
  BandSamples out;
  out.colour.create(grid.azimuths, grid.elevations, CV_32FC3);
  out.shown.create(grid.azimuths, grid.elevations, CV_8UC1);
  const float right = static_cast<float>(image.cols - 1), bottom = static_cast<float>(image.rows - 1);
  const std::size_t stride = image.step[0];
  std::vector<Eigen::Vector2f> column(static_cast<std::size_t>(ne));
  for (int i = 0; i < grid.azimuths; ++i) {
    const int ki = i / per_azimuth;
    const float fa = static_cast<float>(i - ki * per_azimuth) / static_cast<float>(per_azimuth);
    for (int j = 0; j < ne; ++j) {
      const auto at = static_cast<std::size_t>(ki * ne + j);
      column[static_cast<std::size_t>(j)] =
          (1 - fa) * knots[at] + fa * knots[at + static_cast<std::size_t>(ne)];
    }
    auto* colour = out.colour.ptr<cv::Vec3f>(i);
    auto* shown = out.shown.ptr<uchar>(i);
    for (int j = 0; j < grid.elevations; ++j) {
      const int kj = std::min(j / per_elevation, ne - 2 < 0 ? 0 : ne - 2);
      const float fe = static_cast<float>(j - kj * per_elevation) / static_cast<float>(per_elevation);
      const Eigen::Vector2f& below = column[static_cast<std::size_t>(kj)];
      const Eigen::Vector2f uv =
          ne == 1 ? below : Eigen::Vector2f((1 - fe) * below + fe * column[static_cast<std::size_t>(kj + 1)]);
      // Written so that NaN is not inside.
      if (!(uv.x() >= 0 && uv.y() >= 0 && uv.x() < right && uv.y() < bottom)) {
        shown[j] = 0;
        colour[j] = {0, 0, 0};
        continue;
      }
      const int x = static_cast<int>(uv.x()), y = static_cast<int>(uv.y());
      const float fx = uv.x() - static_cast<float>(x), fy = uv.y() - static_cast<float>(y);
      if (!forbidden_.empty() &&
          forbidden_.at<uchar>(std::min(forbidden_.rows - 1, y * reduction + reduction / 2),
                               std::min(forbidden_.cols - 1, x * reduction + reduction / 2))) {
        shown[j] = 0;
        colour[j] = {0, 0, 0};
        continue;
      }
      shown[j] = 255;
      const uchar* p = image.ptr<uchar>(y) + 3 * x;
      const uchar* q = p + stride;
      for (int k = 0; k < 3; ++k) {
        const float top = static_cast<float>(p[k]) + fx * static_cast<float>(p[k + 3] - p[k]);
        const float low = static_cast<float>(q[k]) + fx * static_cast<float>(q[k + 3] - q[k]);
        colour[j][k] = top + fy * (low - top);
      }
    }
  }
  return out;
}

}  // namespace kestrel::vision
