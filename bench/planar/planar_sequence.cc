// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_sequence.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "base/random.h"
#include "bench/planar/planar_pictures.h"
#include "geometry/tait_bryan.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFine = 2;       // samples along each side of a pixel
constexpr int kInstants = 12;  // of an exposure
constexpr double kNoise_grey = 2;
constexpr double kDistance_m = 3.6;                  // 270 x 203 pixels
constexpr double kBackground_m = 30, kBehind_m = 2;  // its side, and how far behind the picture
constexpr double kSheet_m = 3;

std::vector<cv::Mat> Pyramid(const cv::Mat& picture) {
  std::vector<cv::Mat> levels{picture};
  while (std::min(levels.back().cols, levels.back().rows) > 40) {
    cv::Mat half;
    cv::resize(levels.back(), half, {levels.back().cols / 2, levels.back().rows / 2}, 0, 0, cv::INTER_AREA);
    levels.push_back(half);
  }
  return levels;
}

// Draws a picture of so many metres onto an image, of pixels that are kFine times finer, where it lies within
// it. H: from the plane, m, x up in the picture, y right, to the fine image. px_per_m: of that.
void Put(const std::vector<cv::Mat>& levels, double length_m, double width_m, const Matrix3d& H,
         double px_per_m, cv::Mat& image) {
  std::size_t level = 0;
  while (level + 1 < levels.size() && levels[level + 1].cols / width_m > px_per_m) ++level;
  const cv::Mat& picture = levels[level];
  Matrix3d plane_from_pixel;
  plane_from_pixel << 0, -length_m / picture.rows, length_m / 2 - 0.5 * length_m / picture.rows,  //
      width_m / picture.cols, 0, -width_m / 2 + 0.5 * width_m / picture.cols,                     //
      0, 0, 1;
  cv::Mat map;
  cv::eigen2cv(Matrix3d(H * plane_from_pixel), map);
  cv::warpPerspective(picture, image, map, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
}

// The largest of a plane's scales in the image near a point of it, px/m.
double ScaleAt(const Matrix3d& H, const Vector2d& p) {
  constexpr double kStep_m = 1e-3;
  const Vector2d at = vision::Transfer(H, p);
  return std::max((vision::Transfer(H, p + Vector2d(kStep_m, 0)) - at).norm(),
                  (vision::Transfer(H, p + Vector2d(0, kStep_m)) - at).norm()) /
         kStep_m;
}

double Exposure_s(PlanarFactor factor) {
  return factor == PlanarFactor::kMotionBlur      ? 0.6 / kPlanarRate_hz
         : factor == PlanarFactor::kUnconstrained ? 0.25 / kPlanarRate_hz
                                                  : 0;
}

// From 0 to 1 and back, resting at 1.
double Excursion(double t_s, double from_s, double until_s) {
  constexpr double kGo_s = 0.7;
  const auto smooth = [](double x) { return x * x * (3 - 2 * x); };
  return smooth(std::clamp((t_s - from_s) / kGo_s, 0.0, 1.0)) *
         smooth(std::clamp((until_s - t_s) / kGo_s, 0.0, 1.0));
}

}  // namespace

const char* NameOf(PlanarFactor factor) {
  switch (factor) {
    case PlanarFactor::kScale:
      return "scale";
    case PlanarFactor::kRotation:
      return "rotation";
    case PlanarFactor::kPerspective:
      return "perspective";
    case PlanarFactor::kMotionBlur:
      return "motion blur";
    case PlanarFactor::kOcclusion:
      return "occlusion";
    case PlanarFactor::kOutOfView:
      return "out of view";
    case PlanarFactor::kUnconstrained:
      return "unconstrained";
  }
  return "";
}

std::array<Vector2d, 4> PlanarCorners() {
  const double x = kPlanarLength_m / 2, y = kPlanarWidth_m / 2;
  return {{{x, -y}, {x, y}, {-x, y}, {-x, -y}}};
}

PlanarSequence::PlanarSequence(const cv::Mat& picture, PlanarFactor factor, std::uint64_t seed)
    : factor_(factor), seed_(seed), picture_(Pyramid(picture)) {
  RandomStream random(seed, fmt::format("planar {}", NameOf(factor)));
  for (double& phase : phases_) phase = random.Uniform(0, 2 * std::numbers::pi);
  side_ = random.Uniform(-1, 1) < 0 ? -1 : 1;
  background_ = Pyramid(Blotches({2048, 2048}, 6, 16, random.Bits()));
  sheet_ = Pyramid(Blotches({512, 512}, 8, 30, random.Bits()));
}

double PlanarSequence::Wave(int which, double hz, double t_s) const {
  return std::sin(2 * std::numbers::pi * hz * t_s + phases_[static_cast<std::size_t>(which)]);
}

Pose PlanarSequence::X_CT(double t_s) const {
  // The picture is upright in the image, and the hand that holds it is never quite still.
  Vector3d p(0.05 * Wave(0, 0.4, t_s), 0.05 * Wave(1, 0.5, t_s), kDistance_m);
  double yaw = -90 + 2 * Wave(2, 0.3, t_s), tilt_x = 2 * Wave(3, 0.35, t_s), tilt_y = 2 * Wave(4, 0.45, t_s);
  // Factors come in gently: the first image shows the picture whole.
  const double ramp = std::min(1.0, t_s / 1.0), in = ramp * ramp * (3 - 2 * ramp);
  const auto scale = [&](double low, double high, double hz) {  // geometric, about 1 at the beginning
    const double w = Wave(5, hz, t_s);
    return std::exp(in * (std::log(high / low) * w / 2 + std::log(high * low) / 2));
  };
  switch (factor_) {
    case PlanarFactor::kScale:
      p.z() *= scale(0.6, 3.5, 0.3);
      break;
    case PlanarFactor::kRotation:
      yaw += side_ * in * 80 * t_s + in * 25 * Wave(6, 0.7, t_s);
      break;
    case PlanarFactor::kPerspective:
      tilt_x += in * 58 * Wave(7, 0.25, t_s);
      tilt_y += in * 52 * Wave(8, 0.33, t_s);
      break;
    case PlanarFactor::kMotionBlur:
      p.x() += in * 0.65 * Wave(6, 1.3, t_s);
      p.y() += in * 0.40 * Wave(7, 1.1, t_s);
      yaw += in * 8 * Wave(8, 0.9, t_s);
      break;
    case PlanarFactor::kOcclusion:
      yaw += in * 15 * Wave(6, 0.3, t_s);
      break;
    case PlanarFactor::kOutOfView:  // twice, to one side, and up or down
      p.x() += side_ * 2.4 * Excursion(t_s, 0.4, 2.6);
      p.y() -= side_ * 1.9 * Excursion(t_s, 3.2, 5.2);
      yaw += in * 20 * Wave(6, 0.2, t_s);
      break;
    case PlanarFactor::kUnconstrained:
      p.z() *= scale(0.7, 2.0, 0.23);
      p.x() += in * 0.7 * Wave(6, 0.45, t_s);
      p.y() += in * 0.45 * Wave(7, 0.37, t_s);
      yaw += in * 70 * Wave(8, 0.27, t_s);
      tilt_x += in * 33 * Wave(9, 0.31, t_s);
      tilt_y += in * 30 * Wave(10, 0.4, t_s);
      break;
  }
  return {ExpRotation({Radians(tilt_x), Radians(tilt_y), 0}) * HeadingRotation(Radians(yaw)), p};
}

// A sheet comes from the left and goes back, twice.
double PlanarSequence::Cover(double t_s) const {
  const double most = factor_ == PlanarFactor::kOcclusion       ? 0.6
                      : factor_ == PlanarFactor::kUnconstrained ? 0.35
                                                                : 0;
  return most * std::max(Excursion(t_s, 0.5, 2.8), Excursion(t_s, 3.3, 5.6));
}

cv::Mat PlanarSequence::Instant(double t_s) const {
  const vision::Pinhole& camera = kPlanarCamera;
  const Pose X = X_CT(t_s);
  Matrix3d fine;
  fine << kFine, 0, (kFine - 1) / 2.0, 0, kFine, (kFine - 1) / 2.0, 0, 0, 1;
  const Matrix3d H = fine * vision::HomographyFromPose(X, camera);
  // The background does not turn with the picture, and moves less: it lies behind it, and the camera moves
  // too.
  const Pose behind{HeadingRotation(Radians(-90)), {0.5 * X.p.x(), 0.5 * X.p.y(), 0.6 * X.p.z() + kBehind_m}};
  const Matrix3d H_behind = fine * vision::HomographyFromPose(behind, camera);
  cv::Mat image(kFine * camera.height_px, kFine * camera.width_px, CV_8UC1, cv::Scalar(115));
  Put(background_, kBackground_m, kBackground_m, H_behind, ScaleAt(H_behind, {0, 0}), image);
  Put(picture_, kPlanarLength_m, kPlanarWidth_m, H, ScaleAt(H, {0, 0}), image);
  if (const double cover = Cover(t_s); cover > 0) {
    Matrix3d sheet_at = Matrix3d::Identity();  // of the sheet's plane in T
    sheet_at(1, 2) = (cover - 0.5) * kPlanarWidth_m - kSheet_m / 2;
    Put(sheet_, kSheet_m, kSheet_m, H * sheet_at, ScaleAt(H, {0, 0}), image);
  }
  return image;
}

PlanarFrame PlanarSequence::Draw(int frame) const {
  const double t_s = frame / kPlanarRate_hz, exposure_s = Exposure_s(factor_);
  cv::Mat light(kFine * kPlanarCamera.height_px, kFine * kPlanarCamera.width_px, CV_32FC1, cv::Scalar(0));
  const int instants = exposure_s > 0 ? kInstants : 1;
  for (int i = 0; i < instants; ++i)
    cv::accumulate(Instant(t_s + exposure_s * ((i + 0.5) / instants - 0.5)), light);
  PlanarFrame drawn;
  cv::Mat seen;
  cv::resize(light, seen, {kPlanarCamera.width_px, kPlanarCamera.height_px}, 0, 0, cv::INTER_AREA);
  seen /= instants;
  cv::Mat noise(seen.size(), CV_32FC1);
  cv::RNG rng(RandomStream::Mix(seed_ ^ RandomStream::Mix(static_cast<std::uint64_t>(frame))) | 1);
  rng.fill(noise, cv::RNG::NORMAL, 0, kNoise_grey);
  seen += noise;
  seen.convertTo(drawn.image, CV_8U);

  drawn.H_w = vision::HomographyFromPose(X_CT(t_s), kPlanarCamera);
  // By area in T: what is right of the sheet, within the image.
  const double left = (Cover(t_s) - 0.5) * kPlanarWidth_m, x = kPlanarLength_m / 2, y = kPlanarWidth_m / 2;
  std::vector<cv::Point2f> open, inside, on_picture;
  const auto add = [](std::vector<cv::Point2f>& to, const Vector2d& p) {
    to.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  };
  for (const Vector2d& corner : {Vector2d(x, left), Vector2d(x, y), Vector2d(-x, y), Vector2d(-x, left)})
    add(open, vision::Transfer(drawn.H_w, corner));
  const float w = static_cast<float>(kPlanarCamera.width_px) - 0.5F,
              h = static_cast<float>(kPlanarCamera.height_px) - 0.5F;
  const std::vector<cv::Point2f> image = {{-0.5F, -0.5F}, {w, -0.5F}, {w, h}, {-0.5F, h}};
  drawn.visible = 0;
  if (cv::intersectConvexConvex(open, image, inside) > 0) {
    const Matrix3d back = drawn.H_w.inverse();
    for (const cv::Point2f& p : inside) add(on_picture, vision::Transfer(back, {p.x, p.y}));
    drawn.visible = cv::contourArea(on_picture) / (kPlanarLength_m * kPlanarWidth_m);
  }
  return drawn;
}

}  // namespace kestrel::bench
