// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/views.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kSteepest = 75 * pi / 180;  // of what WholePanorama unrolls from a cylinder

// The share of a length at which a pixel's centre lies, its edges being 0 and 1.
double ShareAt(double pixel, int length_px) { return (pixel + 0.5) / length_px; }
double PixelAt(double share, int length_px) { return share * length_px - 0.5; }

// Between the centres of the outermost pixels; what is not a number is not.
bool Inside(const CameraModel& camera, const Vector2d& uv) {
  return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= WidthPx(camera) - 1 && uv.y() <= HeightPx(camera) - 1;
}

// Where a direction is found in the image; none outside the lens or off the image.
std::optional<Vector2d> InImage(const CameraModel& camera, const Vector3d& direction_C) {
  const auto uv = Project(camera, direction_C);
  return uv && Inside(camera, *uv) ? uv : std::nullopt;
}

// Rows of a panorama, from its bottom up.
double Height(const Panorama& p, double elevation) {
  return p.rows == Panorama::Rows::kTangent ? std::tan(elevation) : elevation;
}

Vector3d Direction(double azimuth, double elevation) {  // in V
  return {std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
          std::cos(azimuth) * std::cos(elevation)};
}

std::optional<Vector2d> Source(const PerspectiveView& view, const CameraModel& camera, const Vector2d& uv) {
  const auto ray = view.camera.Ray(uv);
  return ray ? InImage(camera, view.R_VC.transpose() * *ray) : std::nullopt;  // eq. (6.6), backwards
}

std::optional<Vector2d> Source(const Panorama& p, const CameraModel& camera, const Vector2d& uv) {
  const double azimuth = std::lerp(p.azimuth_from, p.azimuth_to, ShareAt(uv.x(), p.width_px));
  const double height =
      std::lerp(Height(p, p.elevation_to), Height(p, p.elevation_from), ShareAt(uv.y(), p.height_px));
  const double elevation = p.rows == Panorama::Rows::kTangent ? std::atan(height) : height;
  return InImage(camera, p.R_VC.transpose() * Direction(azimuth, elevation));
}

std::optional<Vector2d> Source(const PolarUnwrapping& p, const CameraModel& camera, const Vector2d& uv) {
  const double alpha = std::lerp(p.alpha_from, p.alpha_to, ShareAt(uv.x(), p.width_px));
  const double radius = std::lerp(p.radius_top, p.radius_bottom, ShareAt(uv.y(), p.height_px));
  const Vector2d at = p.centre + radius * Vector2d(std::cos(alpha), std::sin(alpha));  // eq. (6.17)
  if (!Inside(camera, at) || !Ray(camera, at)) return std::nullopt;
  return at;
}

std::optional<Vector2d> Source(const SpherePicture& s, const CameraModel& camera, const Vector2d& uv) {
  const double radius = std::min(s.width_px, s.height_px) / 2.0;
  const Vector2d at =
      (uv - Vector2d(PixelAt(0.5, s.width_px), PixelAt(0.5, s.height_px))) / radius;  // x and y in V
  const double depth = 1 - at.squaredNorm();
  if (depth < 0) return std::nullopt;
  const Vector3d near(at.x(), at.y(), -std::sqrt(depth)), far(at.x(), at.y(), std::sqrt(depth));
  const auto outside = InImage(camera, s.R_VC.transpose() * near);
  return outside ? outside : InImage(camera, s.R_VC.transpose() * far);
}

// The tangent of the largest angle from the optical axis, up to a limit, that is seen towards a side of C.
double Reach(const CameraModel& camera, const Vector2d& side, double most_rad) {
  double seen = 0, unseen = most_rad;
  for (int i = 0; i < 50; ++i) {
    const double angle = i == 0 ? most_rad : (seen + unseen) / 2;
    const Vector3d direction(side.x() * std::sin(angle), side.y() * std::sin(angle), std::cos(angle));
    if (!InImage(camera, direction)) {
      unseen = angle;
    } else if (i == 0) {
      return std::tan(most_rad);
    } else {
      seen = angle;
    }
  }
  return std::tan(seen);
}

// The shortest arc of a circle that holds all marked bins, as [first, last + 1) in bins, first >= 0. Gaps of
// less than `least_gap` bins are none.
std::pair<int, int> ArcOf(const std::vector<bool>& marked, int least_gap) {
  const int n = static_cast<int>(marked.size());
  int longest = 0, end_of_longest = 0, run = 0;
  for (int i = 0; i < 2 * n; ++i) {
    run = marked[i % n] ? 0 : run + 1;
    if (run > longest && run < n) longest = run, end_of_longest = i + 1;
  }
  if (longest < least_gap) return {0, n};
  const int first = end_of_longest % n;
  return {first, first + n - longest};
}

}  // namespace

Eigen::Matrix3d ViewRotation(double yaw, double pitch, double roll) {
  Eigen::Matrix3d R_FC;  // F: forward, right, down
  R_FC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return R_FC.transpose() * RotationFromTaitBryan({yaw, pitch, roll}).transpose() * R_FC;
}

cv::Size SizeOf(const View& view) {
  return std::visit(
      [](const auto& v) -> cv::Size {
        if constexpr (requires { v.camera; }) {
          return {v.camera.width_px, v.camera.height_px};
        } else {
          return {v.width_px, v.height_px};
        }
      },
      view);
}

std::optional<Vector2d> SourceOf(const View& view, const CameraModel& camera, const Vector2d& uv) {
  return std::visit([&](const auto& v) { return Source(v, camera, uv); }, view);
}

std::optional<Vector2d> Project(const Panorama& p, const Vector3d& p_CQ) {
  const Vector3d q = (p.R_VC * p_CQ).normalized();
  const double elevation = std::asin(std::clamp(-q.y(), -1.0, 1.0));
  const double middle = (p.azimuth_from + p.azimuth_to) / 2;  // the turn that is cut opposite to it
  const double azimuth = middle + WrapAngle(std::atan2(q.x(), q.z()) - middle);
  const Vector2d share((azimuth - p.azimuth_from) / (p.azimuth_to - p.azimuth_from),
                       (Height(p, p.elevation_to) - Height(p, elevation)) /
                           (Height(p, p.elevation_to) - Height(p, p.elevation_from)));
  if (!(share.minCoeff() >= 0 && share.maxCoeff() <= 1)) return std::nullopt;
  return Vector2d(PixelAt(share.x(), p.width_px), PixelAt(share.y(), p.height_px));
}

ViewTable MakeViewTable(const View& view, const CameraModel& camera) {
  const cv::Size size = SizeOf(view);
  ViewTable table;
  table.source = {WidthPx(camera), HeightPx(camera)};
  table.shown = cv::Mat(size, CV_8UC1, cv::Scalar(0));
  cv::Mat exact(size, CV_32FC2, cv::Scalar(-9, -9));  // off the image
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const auto at = SourceOf(view, camera, Vector2d(u, v));
      if (!at) continue;
      exact.at<cv::Vec2f>(v, u) = {static_cast<float>(at->x()), static_cast<float>(at->y())};
      table.shown.at<uchar>(v, u) = 255;
    }
  }
  cv::convertMaps(exact, cv::noArray(), table.place, table.fraction, CV_16SC2);
  return table;
}

double ShownShare(const ViewTable& table) {
  return static_cast<double>(cv::countNonZero(table.shown)) / static_cast<double>(table.shown.total());
}

cv::Mat Look(const ViewTable& table, const cv::Mat& image) {
  assert(image.depth() == CV_8U && image.size() == table.source);
  cv::Mat view;
  cv::remap(image, view, table.place, table.fraction, cv::INTER_LINEAR, cv::BORDER_CONSTANT, {});
  return view;
}

double CentralResolution(const CameraModel& camera) {
  constexpr double kStep = 1e-4;  // rad to each side
  double sum = 0;
  for (const Vector3d& side : {Vector3d::UnitX().eval(), Vector3d::UnitY().eval()}) {
    const auto ahead = Project(camera, Vector3d::UnitZ() + kStep * side);
    const auto behind = Project(camera, Vector3d::UnitZ() - kStep * side);
    assert(ahead && behind);
    sum += (*ahead - *behind).norm() / (2 * kStep);
  }
  return sum / 2;
}

std::optional<Pinhole> CentralPinhole(const CameraModel& camera, double most_field_rad) {
  if (!InImage(camera, Vector3d::UnitZ())) return std::nullopt;
  const double f = CentralResolution(camera);
  const double half = most_field_rad / 2;
  const double left = Reach(camera, {-1, 0}, half), right = Reach(camera, {1, 0}, half);
  const double up = Reach(camera, {0, -1}, half), down = Reach(camera, {0, 1}, half);
  return Pinhole{static_cast<int>(f * (left + right)) + 1,
                 static_cast<int>(f * (up + down)) + 1,
                 f,
                 f,
                 f * left,
                 f * up};
}

double MeanResolution(const CameraModel& camera) {
  // The solid angle that is seen, by directions spread evenly over the sphere on a spiral.
  constexpr int kDirections = 40000;
  const double golden_turn = pi * (3 - std::sqrt(5.0));
  int seen = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    if (InImage(camera, {r * std::cos(golden_turn * i), r * std::sin(golden_turn * i), z})) ++seen;
  }
  int pixels = 0;
  constexpr int kStep_px = 2;
  for (int v = 0; v < HeightPx(camera); v += kStep_px) {
    for (int u = 0; u < WidthPx(camera); u += kStep_px) pixels += Ray(camera, Vector2d(u, v)) ? 1 : 0;
  }
  if (seen == 0 || pixels == 0) return CentralResolution(camera);
  return std::sqrt(pixels * kStep_px * kStep_px / (4 * pi * seen / kDirections));
}

cv::Size MatchedSize(const Panorama& p, const CameraModel& camera) {
  const double px_per_rad = MeanResolution(camera);
  const auto px = [&](double extent) {
    return std::max(1, static_cast<int>(std::lround(px_per_rad * std::abs(extent))));
  };
  return {px(p.azimuth_to - p.azimuth_from), px(Height(p, p.elevation_to) - Height(p, p.elevation_from))};
}

std::optional<Panorama> WholePanorama(const CameraModel& camera, const Eigen::Matrix3d& R_VC,
                                      Panorama::Rows rows) {
  constexpr int kStep_px = 2, kBins = 360, kLeastGap = 8;
  double lowest = pi, highest = -pi;
  std::vector<bool> azimuths(kBins, false);
  for (int v = 0; v < HeightPx(camera); v += kStep_px) {
    for (int u = 0; u < WidthPx(camera); u += kStep_px) {
      const auto ray = Ray(camera, Vector2d(u, v));
      if (!ray) continue;
      const Vector3d q = R_VC * *ray;
      const double elevation = std::asin(std::clamp(-q.y(), -1.0, 1.0));
      lowest = std::min(lowest, elevation);
      highest = std::max(highest, elevation);
      const double turn = std::atan2(q.x(), q.z()) / (2 * pi) + 1;
      azimuths[static_cast<int>(turn * kBins) % kBins] = true;
    }
  }
  if (lowest > highest) return std::nullopt;  // no ray at all
  if (InImage(camera, R_VC.transpose() * -Vector3d::UnitY())) highest = pi / 2;
  if (InImage(camera, R_VC.transpose() * Vector3d::UnitY())) lowest = -pi / 2;
  if (rows == Panorama::Rows::kTangent) {
    lowest = std::clamp(lowest, -kSteepest, kSteepest);
    highest = std::clamp(highest, -kSteepest, kSteepest);
  }
  if (!(highest > lowest)) return std::nullopt;
  const auto [first, end] = ArcOf(azimuths, kLeastGap);
  Panorama p;
  p.rows = rows;
  p.R_VC = R_VC;
  p.elevation_from = lowest, p.elevation_to = highest;
  p.azimuth_from = first * 2 * pi / kBins, p.azimuth_to = end * 2 * pi / kBins;
  // The middle of the picture is as near to straight ahead as it can be.
  const double turns = end - first == kBins ? 0.5 : std::round((first + end) / (2.0 * kBins));
  p.azimuth_from -= turns * 2 * pi, p.azimuth_to -= turns * 2 * pi;
  const cv::Size size = MatchedSize(p, camera);
  p.width_px = size.width, p.height_px = size.height;
  return p;
}

}  // namespace kestrel::vision
