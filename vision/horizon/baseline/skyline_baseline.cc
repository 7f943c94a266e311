// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/baseline/skyline_baseline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"
#include "vision/camera/views.h"
#include "vision/horizon/baseline/pyramid_segmentation.h"
#include "vision/horizon/border/skyline_fix.h"
#include "vision/horizon/circle_fit.h"

namespace kestrel::vision {

namespace {
constexpr double kWindow = 0.4;  // of the image's height, of the adaptive threshold
// Grey levels below the mean of the window: what OpenCV had unless it was told.
constexpr double kOffset = 5;
constexpr int kEllipsePoints = 360;
}  // namespace

cv::Mat SkyWeight(const cv::Mat& image) {
  cv::Mat out(image.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    const auto* p = image.ptr<cv::Vec3b>(y);
    auto* q = out.ptr<uchar>(y);
    for (int x = 0; x < image.cols; ++x) {
      const int sum = p[x][0] + p[x][1] + p[x][2];
      q[x] = sum == 0 ? uchar{0} : cv::saturate_cast<uchar>(3.0 * p[x][0] * p[x][0] / sum);
    }
  }
  return out;
}

SkylineBaseline::SkylineBaseline(const CameraModel& camera, const Eigen::Matrix3d& R_BC)
    : camera_(camera), R_BC_(R_BC), lens_(HeightPx(camera), WidthPx(camera), CV_8UC1) {
  for (int y = 0; y < lens_.rows; ++y)
    for (int x = 0; x < lens_.cols; ++x) lens_.at<uchar>(y, x) = Ray(camera, {x, y}) ? 255 : 0;
  // The rim of the lens is an edge of its own.
  cv::erode(lens_, lens_, cv::Mat(), {-1, -1}, 3);
}

std::optional<BaselineAttitude> SkylineBaseline::Measure(const cv::Mat& image) const {
  if (image.size() != lens_.size() || image.type() != CV_8UC3) return std::nullopt;
  BaselineAttitude out;
  out.segments = SegmentByPyramid(SkyWeight(image));
  out.segments.setTo(cv::mean(out.segments, lens_)[0], ~lens_);  // black outside would pull the threshold
  const int window = static_cast<int>(kWindow * image.rows) | 1;
  cv::adaptiveThreshold(out.segments, out.ground, 255, cv::ADAPTIVE_THRESH_GAUSSIAN_C, cv::THRESH_BINARY_INV,
                        window, kOffset);
  out.ground &= lens_;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(out.ground, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (contours.empty()) return std::nullopt;
  const auto& ground = *std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
  if (ground.size() < 20) return std::nullopt;
  out.ellipse = cv::fitEllipse(ground);
  const double c = std::cos(Radians(static_cast<double>(out.ellipse.angle)));
  const double s = std::sin(Radians(static_cast<double>(out.ellipse.angle)));
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < kEllipsePoints; ++k) {
    const double a = 2 * M_PI * k / kEllipsePoints;
    const double x = static_cast<double>(out.ellipse.size.width) / 2 * std::cos(a);
    const double y = static_cast<double>(out.ellipse.size.height) / 2 * std::sin(a);
    const Eigen::Vector2d uv(static_cast<double>(out.ellipse.center.x) + c * x - s * y,
                             static_cast<double>(out.ellipse.center.y) + s * x + c * y);
    if (const auto ray = Ray(camera_, uv)) points.push_back(R_BC_ * *ray);
  }
  if (points.size() < kEllipsePoints / 3) return std::nullopt;
  const auto plane = FitPlane(points);
  if (!plane) return std::nullopt;
  out.down_B = plane->Down();
  const RollPitch angles = RollPitchFromDown(out.down_B);
  out.roll = angles.roll, out.pitch = angles.pitch;
  return out;
}

CompassBaseline::CompassBaseline(const CameraModel& camera, const Ring& ring)
    : map_(ring.height_px, ring.width_px, CV_32FC2),
      clockwise_(ring.clockwise),
      per_column_(Radians(kField_deg) / ring.width_px) {
  PolarUnwrapping polar;
  polar.width_px = ring.width_px, polar.height_px = ring.height_px;
  polar.centre = ring.centre;
  polar.alpha_from = ring.nose - Radians(kField_deg) / 2;
  polar.alpha_to = ring.nose + Radians(kField_deg) / 2;
  polar.radius_top = ring.radius_outer, polar.radius_bottom = ring.radius_inner;
  for (int y = 0; y < ring.height_px; ++y)
    for (int x = 0; x < ring.width_px; ++x) {
      const auto uv = SourceOf(View(polar), camera, {x, y});
      map_.at<cv::Vec2f>(y, x) =
          uv ? cv::Vec2f(static_cast<float>(uv->x()), static_cast<float>(uv->y())) : cv::Vec2f(-1e4f, -1e4f);
    }
}

double CompassBaseline::Distance(const cv::Mat& a, const cv::Mat& b, int shift) {
  const int width = a.cols - std::abs(shift);
  if (width <= 0) return std::numeric_limits<double>::infinity();
  const cv::Rect in_a(std::max(0, -shift), 0, width, a.rows), in_b(std::max(0, shift), 0, width, a.rows);
  return cv::norm(a(in_a), b(in_b), cv::NORM_L2) / std::sqrt(static_cast<double>(width) * a.rows);
}

cv::Mat CompassBaseline::Unwrap(const cv::Mat& image) const {
  cv::Mat panorama;
  cv::remap(image, panorama, map_, cv::noArray(), cv::INTER_LINEAR);
  return panorama;
}

int CompassBaseline::BestShift(const cv::Mat& a, const cv::Mat& b) {
  const int reach = a.cols / 4;
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int shift = -reach; shift <= reach; ++shift) {
    const double d = Distance(a, b, shift);
    if (d < least) least = d, best = shift;
  }
  return best;
}

double CompassBaseline::Turn(const cv::Mat& image) {
  const cv::Mat panorama = Unwrap(image);
  // What is seen moves against the turn. (6.19)
  if (!last_.empty()) total_ -= clockwise_ * BestShift(last_, panorama) * per_column_;
  last_ = panorama;
  return total_;
}

CompassBaseline::Ring GroundRing(const CameraModel& camera, const Eigen::Matrix3d& R_BC, double px_per_deg) {
  const auto at = [&](double elevation_deg) {
    const double e = Radians(elevation_deg);
    const Eigen::Vector3d ahead_B(std::cos(e), 0, -std::sin(e));
    return Project(camera, R_BC.transpose() * ahead_B);
  };
  CompassBaseline::Ring ring;
  ring.centre = Parameters(camera).segment<2>(2);
  ring.width_px = static_cast<int>(std::lround(CompassBaseline::kField_deg * px_per_deg));
  const auto inner = at(-30), outer = at(10);
  if (inner && outer) {
    ring.radius_inner = (*inner - ring.centre).norm();
    ring.radius_outer = (*outer - ring.centre).norm();
    const Eigen::Vector2d ahead = *outer - ring.centre;
    ring.nose = std::atan2(ahead.y(), ahead.x());
  }
  return ring;
}

}  // namespace kestrel::vision
