// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/view_warp.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/pose.h"
#include "vision/enhance/canvas/pixel_map.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kStep_px = 16;  // between the pixels of a view whose source is calculated by itself

bool RowsDiffer(const ImageView& view) { return view.R_NC_rows.size() > 1 || view.row_warps.size() > 1; }

Eigen::Matrix3d RowWarp(const ImageView& view, double row) {
  if (view.row_warps.size() < 2 || view.rows < 2) return Eigen::Matrix3d::Identity();
  const auto intervals = static_cast<double>(view.row_warps.size() - 1);
  const double place = row / (view.rows - 1) * intervals,
               from = std::clamp(std::floor(place), 0.0, intervals - 1);
  const auto i = static_cast<std::size_t>(from);
  return view.row_warps[i] + (place - from) * (view.row_warps[i + 1] - view.row_warps[i]);
}

// As SourceOf, with the view's inverse.
std::optional<Vector2d> Source(const ImageView& view, const Eigen::Matrix3d& H_back,
                               const CameraModel* camera, const Vector2d& uv) {
  const int rows = view.rows;
  const Vector2d seen = Transfer(H_back, uv);
  const auto seen_by = [&](double row) -> std::optional<Vector2d> {
    const Vector2d then = Transfer(RowWarp(view, row), seen);
    if (!view.turned) return then;
    const auto ray_V = view.virtual_camera.Ray(then);
    if (!ray_V) return std::nullopt;
    return Project(*camera, AttitudeOfRow(view.R_NC_rows, rows, row).conjugate() * (view.R_NV * *ray_V));
  };
  // Which row saw it depends on where it was seen: a few steps, each of which shrinks the error by the share of the
  // image that the camera turns in the time that it takes to read it.
  constexpr int kSteps = 6;
  std::optional<Vector2d> at;
  double row = (rows - 1) / 2.0;
  for (int i = 0; i < kSteps; ++i) {
    at = seen_by(row);
    if (!at || !RowsDiffer(view) || std::abs(at->y() - row) < 1e-3) break;
    row = std::clamp(at->y(), -1.0 * rows, 2.0 * rows);
  }
  return at;
}

cv::Mat Draw(const ImageView& view, const CameraModel* camera, const cv::Mat& image, int border,
             cv::Mat* shown) {
  cv::Mat drawn;
  if (!view.turned && !RowsDiffer(view)) {
    cv::Mat H;
    cv::eigen2cv(view.H, H);
    cv::warpPerspective(image, drawn, H, view.size, cv::INTER_LINEAR, border);
    if (shown)
      cv::warpPerspective(cv::Mat(image.size(), CV_8UC1, cv::Scalar(255)), *shown, H, view.size,
                          cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  } else {
    const Eigen::Matrix3d H_back = view.H.inverse();
    const PixelMap map = MakePixelMap(cv::Rect({}, view.size), kStep_px,
                                      [&](const Vector2d& uv) { return Source(view, H_back, camera, uv); });
    cv::remap(image, drawn, map.u, map.v, cv::INTER_LINEAR, border);
    if (shown)
      cv::remap(cv::Mat(image.size(), CV_8UC1, cv::Scalar(255)), *shown, map.u, map.v, cv::INTER_LINEAR,
                cv::BORDER_CONSTANT);
  }
  if (shown) *shown = *shown == 255;
  return drawn;
}

}  // namespace

Eigen::Quaterniond AttitudeOfRow(const std::vector<Eigen::Quaterniond>& R_NC_rows, int rows, double row) {
  if (R_NC_rows.empty()) return Eigen::Quaterniond::Identity();
  if (R_NC_rows.size() == 1 || rows < 2) return R_NC_rows.front();
  const auto intervals = static_cast<double>(R_NC_rows.size() - 1);
  const double place = row / (rows - 1) * intervals;
  // Beyond the first and last row the camera turns on as it did there.
  const double from = std::clamp(std::floor(place), 0.0, intervals - 1);
  const auto i = static_cast<std::size_t>(from);
  return R_NC_rows[i] *
         ExpRotation((place - from) * LogRotation(R_NC_rows[i].conjugate() * R_NC_rows[i + 1]));
}

std::optional<Vector2d> SourceOf(const ImageView& view, const CameraModel* camera, const Vector2d& uv) {
  return Source(view, view.H.inverse(), camera, uv);
}

std::optional<Vector2d> ShownAt(const ImageView& view, const CameraModel* camera, const Vector2d& uv) {
  std::optional<Vector2d> then = uv;
  if (view.turned) {
    const auto ray_C = Ray(*camera, uv);
    if (!ray_C) return std::nullopt;
    then = view.virtual_camera.Project(view.R_NV.conjugate() *
                                       (AttitudeOfRow(view.R_NC_rows, view.rows, uv.y()) * *ray_C));
    if (!then) return std::nullopt;
  }
  return Transfer(view.H * RowWarp(view, uv.y()).inverse(), *then);
}

cv::Mat DrawView(const ImageView& view, const CameraModel* camera, const cv::Mat& image, cv::Mat* shown) {
  return Draw(view, camera, image, cv::BORDER_CONSTANT, shown);
}

cv::Mat DrawViewBeyond(const ImageView& view, const CameraModel* camera, const cv::Mat& image) {
  return Draw(view, camera, image, cv::BORDER_REPLICATE, nullptr);
}

}  // namespace kestrel::vision
