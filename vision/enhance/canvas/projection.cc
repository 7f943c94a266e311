// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/projection.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

// Half of an image, each pixel the mean of four.
cv::Mat HalfOf(const cv::Mat& image) {
  cv::Mat half;
  cv::resize(image, half, {std::max(1, image.cols / 2), std::max(1, image.rows / 2)}, 0, 0, cv::INTER_AREA);
  return half;
}

// Of maps from a canvas to an image: exact at every so many pixels, which leaves less than 0.02 px between.
constexpr int kStep_px = 12;

// The rows of a part, at all azimuths from minus to plus half a turn; of a plane, the part.
cv::Rect WithinPeriod(const cv::Rect& part, int period_px) {
  return period_px == 0 ? part : cv::Rect(-period_px / 2, part.y, period_px, part.height);
}

}  // namespace

bool InImage(cv::Size size, const Vector2d& uv) {
  return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= size.width - 1 && uv.y() <= size.height - 1;
}

Projection::Projection(const CameraModel& camera, Surface surface, double f_px)
    : camera_(camera), surface_(surface), f_px_(f_px) {
  if (surface == Surface::kPlane) return;
  constexpr double kMultiple_px = 64;
  period_px_ = static_cast<int>(kMultiple_px * std::max(1.0, std::round(2 * pi * f_px / kMultiple_px)));
  f_px_ = period_px_ / (2 * pi);
}

std::optional<Vector2d> Projection::ToSurface(const Matrix3d& M_WC, const Vector2d& uv) const {
  const auto ray = Ray(camera_, uv);
  return ray ? OnSurface(surface_, f_px_, M_WC * *ray) : std::nullopt;
}

std::optional<Vector2d> Projection::ToImage(const Matrix3d& M_CW, const Vector2d& place) const {
  Vector2d at = place;
  if (period_px_ > 0) at.x() -= period_px_ * std::round(at.x() / period_px_);
  const auto w = FromSurface(surface_, f_px_, at);
  return w ? Project(camera_, M_CW * *w) : std::nullopt;
}

cv::Rect Projection::PartOf(const Matrix3d& M_WC) const {
  constexpr int kAcross = 40, kDown = 30;
  const cv::Size size = image_size();
  double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
  std::optional<double> azimuth;  // of the first place, about which the others are
  const auto include = [&](const Vector2d& uv) {
    auto at = ToSurface(M_WC, uv);
    if (!at) return;
    if (period_px_ > 0) {
      if (!azimuth) azimuth = at->x();
      at->x() -= period_px_ * std::round((at->x() - *azimuth) / period_px_);
    }
    left = std::min(left, at->x()), right = std::max(right, at->x());
    top = std::min(top, at->y()), bottom = std::max(bottom, at->y());
  };
  include({(size.width - 1) / 2.0, (size.height - 1) / 2.0});
  for (int i = 0; i <= kDown; ++i)
    for (int j = 0; j <= kAcross; ++j)
      include({(size.width - 1.0) * j / kAcross, (size.height - 1.0) * i / kDown});
  if (!(right >= left)) return {};
  if (period_px_ > 0) {  // about a pole it is seen all around
    const Matrix3d M_CW = M_WC.inverse();
    for (const double down : {-1.0, 1.0}) {
      const auto pole = Project(camera_, M_CW * Vector3d(0, down, 0));
      if (!pole || !InImage(size, *pole)) continue;
      left = -period_px_ / 2.0, right = period_px_ / 2.0 - 1;
      if (surface_ == Surface::kSphere) (down < 0 ? top : bottom) = down * f_px_ * pi / 2;
    }
  }
  constexpr double kMost = 1e6;  // so that it can be told how much too large it is
  if (left > kMost || right < -kMost || top > kMost || bottom < -kMost) return {};
  constexpr int kMargin_px = 2;  // what the rim may bulge between the places
  const auto whole = [=](double x) { return static_cast<int>(std::clamp(x, -kMost, kMost)); };
  const int x0 = whole(std::floor(left)) - kMargin_px, y0 = whole(std::floor(top)) - kMargin_px;
  int width = whole(std::ceil(right)) + kMargin_px + 1 - x0;
  if (period_px_ > 0) width = std::min(width, period_px_);
  return {x0, y0, width, whole(std::ceil(bottom)) + kMargin_px + 1 - y0};
}

ProjectedImage ProjectImage(const Projection& projection, const cv::Mat& image, const Matrix3d& M_WC,
                            const cv::Rect& part, int halvings, Blending blending,
                            const std::optional<cv::Rect>& within) {
  ProjectedImage projected;
  projected.part = Halved(part, halvings);
  // An image that is finer than the canvas is halved, or single pixels of it would stand for many.
  int finer = 0;
  for (double share = image.size().area() / std::max(1.0, 1.0 * projected.part.area()); share > 3; share /= 4)
    ++finer;
  cv::Mat source = image;
  for (int i = 0; i < finer; ++i) source = HalfOf(source);
  if (within) projected.part &= *within;
  if (projected.part.empty()) return projected;

  const Matrix3d M_CW = M_WC.inverse();
  const double scale = std::ldexp(1.0, halvings), of_image = std::ldexp(1.0, -finer);
  PixelMap map = MakePixelMap(projected.part, kStep_px, [&](const Vector2d& pixel) {
    return projection.ToImage(M_CW, scale * (pixel + Vector2d(0.5, 0.5)) - Vector2d(0.5, 0.5));
  });
  projected.weights = BlendWeights(blending, image.size(), map);
  if (finer > 0) {
    const double shift = 0.5 * of_image - 0.5;
    map.u.convertTo(map.u, CV_32F, of_image, shift);
    map.v.convertTo(map.v, CV_32F, of_image, shift);
  }
  cv::remap(source, projected.pixels, map.u, map.v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return projected;
}

std::vector<cv::Rect> WrappedParts(const cv::Rect& part, int period_px) {
  if (period_px == 0) return {part};
  std::vector<cv::Rect> parts;
  const cv::Rect all(-period_px / 2, part.y, period_px, part.height);
  for (const int periods : {-1, 0, 1}) {
    const cv::Rect moved(part.x + periods * period_px, part.y, part.width, part.height);
    if (!(moved & all).empty()) parts.push_back(moved);
  }
  return parts;
}

void DrawImage(const Projection& projection, const cv::Mat& image, const Matrix3d& M_WC, Canvas& canvas,
               Blending blending) {
  const cv::Rect part = projection.PartOf(M_WC), all = WithinPeriod(part, projection.period_px());
  if (part.empty()) return;
  for (const cv::Rect& moved : WrappedParts(part, projection.period_px())) canvas.MakeRoom(moved & all);
  DrawImageWithin(Halved(all, canvas.halvings()), projection, image, M_WC, canvas, blending);
}

void DrawImageWithin(const cv::Rect& within, const Projection& projection, const cv::Mat& image,
                     const Matrix3d& M_WC, Canvas& canvas, Blending blending) {
  const cv::Rect part = projection.PartOf(M_WC), all = WithinPeriod(part, projection.period_px());
  for (const cv::Rect& moved : WrappedParts(part, projection.period_px())) {
    const cv::Rect wanted = Halved(all, canvas.halvings()) & within;
    if ((Halved(moved, canvas.halvings()) & wanted).empty()) continue;
    const ProjectedImage projected =
        ProjectImage(projection, image, M_WC, moved, canvas.halvings(), blending, wanted);
    canvas.Draw(projected.part, projected.pixels, projected.weights);
  }
}

}  // namespace kestrel::vision
