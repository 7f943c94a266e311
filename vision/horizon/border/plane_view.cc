// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/plane_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

constexpr int kLongest = 480;            // px of the view
constexpr double kWidest = Radians(65);  // off the optical axis
constexpr int kBorderSteps = 200;        // of the way round the image's edge

}  // namespace

PlaneView::PlaneView(const CameraModel& camera, const cv::Mat& forbidden)
    : camera_size_(WidthPx(camera), HeightPx(camera)) {
  const double shrink =
      std::min(1.0, kLongest / static_cast<double>(std::max(camera_size_.width, camera_size_.height)));
  reduced_ = {std::max(1, static_cast<int>(std::lround(camera_size_.width * shrink))),
              std::max(1, static_cast<int>(std::lround(camera_size_.height * shrink)))};
  // How far the view reaches on the plane z = 1.
  const double most = std::tan(kWidest);
  double left = 0, right = 0, top = 0, bottom = 0;
  const auto reach = [&](double u, double v) {
    const auto ray = Ray(camera, {u, v});
    if (!ray || ray->z() < std::cos(kWidest)) return;
    const double x = ray->x() / ray->z(), y = ray->y() / ray->z();
    left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
    bottom = std::max(bottom, y);
  };
  for (int k = 0; k <= kBorderSteps; ++k)
    for (int i = 0; i <= 20; ++i) {
      const double u = (camera_size_.width - 1) * static_cast<double>(k) / kBorderSteps;
      reach(u, (camera_size_.height - 1) * i / 20.0);
    }
  left = std::max(left, -most), right = std::min(right, most);
  top = std::max(top, -most), bottom = std::min(bottom, most);
  const double span = std::max({right - left, bottom - top, 1e-6});
  focal_px_ = (std::max(reduced_.width, reduced_.height) - 1) / span;
  const cv::Size size(std::max(2, static_cast<int>(std::lround((right - left) * focal_px_)) + 1),
                      std::max(2, static_cast<int>(std::lround((bottom - top) * focal_px_)) + 1));
  middle_ = Eigen::Vector2d(-left * focal_px_, -top * focal_px_);
  map_x_.create(size, CV_32FC1);
  map_y_.create(size, CV_32FC1);
  shown_ = cv::Mat::zeros(size, CV_8UC1);
  const double to_reduced_x = static_cast<double>(reduced_.width) / camera_size_.width,
               to_reduced_y = static_cast<double>(reduced_.height) / camera_size_.height;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector3d ray = RayOf({x, y});
      const auto uv = ray.z() < std::cos(kWidest) ? std::nullopt : Project(camera, ray);
      const bool seen = uv && uv->x() >= -0.5 && uv->y() >= -0.5 && uv->x() <= camera_size_.width - 0.5 &&
                        uv->y() <= camera_size_.height - 0.5;
      map_x_.at<float>(y, x) = seen ? static_cast<float>((uv->x() + 0.5) * to_reduced_x - 0.5) : -1e6f;
      map_y_.at<float>(y, x) = seen ? static_cast<float>((uv->y() + 0.5) * to_reduced_y - 0.5) : -1e6f;
      if (!seen) continue;
      const int u = std::clamp(static_cast<int>(std::lround(uv->x())), 0, camera_size_.width - 1);
      const int v = std::clamp(static_cast<int>(std::lround(uv->y())), 0, camera_size_.height - 1);
      if (forbidden.empty() || !forbidden.at<uchar>(v, u)) shown_.at<uchar>(y, x) = 255;
    }
}

cv::Mat PlaneView::Of(const cv::Mat& image) const {
  cv::Mat reduced = image, view;
  if (image.size() != reduced_) cv::resize(image, reduced, reduced_, 0, 0, cv::INTER_AREA);
  cv::remap(reduced, view, map_x_, map_y_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return view;
}

Eigen::Vector3d PlaneView::RayOf(const Eigen::Vector2d& pixel) const {
  return Eigen::Vector3d((pixel.x() - middle_.x()) / focal_px_, (pixel.y() - middle_.y()) / focal_px_, 1)
      .normalized();
}

Eigen::Vector3d PlaneView::DownOf(const SkyBorder& line, double dip) const {
  // normal . (middle + focal p) = offset on the plane z = 1, and sky where it is more.
  const Eigen::Vector3d level = -Eigen::Vector3d(focal_px_ * line.normal.x(), focal_px_ * line.normal.y(),
                                                 line.normal.dot(middle_) - line.offset)
                                     .normalized();
  if (dip == 0) return level;
  // Every ray of the line lies below the horizontal by the dip: in its middle, exactly so.
  const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() - level.z() * level).normalized();
  return (std::cos(dip) * level + std::sin(dip) * ahead).normalized();
}

SkyBorder PlaneView::BorderOf(const Eigen::Vector3d& down_C) const {
  // -down . ((pixel - middle) / focal, 1) = 0
  SkyBorder line;
  const double length = std::max(1e-9, down_C.head<2>().norm());
  line.normal = -down_C.head<2>() / length;
  line.offset = line.normal.dot(middle_) + focal_px_ * down_C.z() / length;
  return line;
}

}  // namespace kestrel::vision
