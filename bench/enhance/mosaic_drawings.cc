// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/mosaic_drawings.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "base/random.h"
#include "bench/planar/planar_pictures.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr int kFinePixel = 2;
constexpr double kNoiseOfImage_grey = 2;
constexpr double kGround_m = 0.04;       // a pixel of the ground's picture
const cv::Size kGroundSize(3000, 4500);  // east, north
const cv::Size kAroundSize(5120, 1280);

Matrix3d FinePixels() {  // to those of the image
  Matrix3d fine;
  fine << 1.0 / kFinePixel, 0, (1.0 - kFinePixel) / (2 * kFinePixel), 0, 1.0 / kFinePixel,
      (1.0 - kFinePixel) / (2 * kFinePixel), 0, 0, 1;
  return fine;
}

cv::Mat Texture(cv::Size size, std::uint64_t seed) {
  cv::Mat texture;
  cv::addWeighted(Blotches(size, 5, 16, seed), 0.8, Blotches(size, 60, 16, seed + 1), 0.6, -45, texture);
  return texture;
}

cv::Mat Developed(const cv::Mat& fine, std::uint64_t seed, int i) {
  cv::Mat seen, noise;
  cv::resize(fine, seen, {kMosaicCamera.width_px, kMosaicCamera.height_px}, 0, 0, cv::INTER_AREA);
  seen.convertTo(seen, CV_32F);
  noise.create(seen.size(), CV_32F);
  cv::RNG rng(RandomStream::Mix(seed ^ RandomStream::Mix(static_cast<std::uint64_t>(i) + 1)) | 1);
  rng.fill(noise, cv::RNG::NORMAL, 0, kNoiseOfImage_grey);
  seen += noise;
  seen.convertTo(seen, CV_8U);
  return seen;
}

}  // namespace

DrawnSurvey::DrawnSurvey(int images, std::uint64_t seed)
    : images_(images), seed_(seed), ground_(Texture(kGroundSize, seed)) {
  RandomStream random(seed, "drawn survey");
  for (double& phase : phases_) phase = random.Uniform(0, 2 * pi);
}

Pose DrawnSurvey::X_NC(int i) const {
  constexpr double kLane_m = 118, kApart_m = 12;
  const int of_lane = images_ / kLanes, lane = std::min(i / of_lane, kLanes - 1), k = i - lane * of_lane;
  const double along = static_cast<double>(k) / std::max(1, of_lane - 1);
  const double north = kLane_m * ((lane % 2 ? 1 - along : along) - 0.5),
               east = kApart_m * (lane - (kLanes - 1) / 2.0);
  const auto sway = [&](int which, double per_image) {
    return std::sin(per_image * i + phases_[static_cast<std::size_t>(which)]);
  };
  const double yaw = (lane % 2 ? pi : 0) + 0.05 * sway(0, 0.10);
  const Pose X_NB{
      Eigen::Quaterniond(RotationFromTaitBryan({yaw, 0.05 * sway(1, 0.23), 0.05 * sway(2, 0.31)})),
      {north + 0.5 * sway(3, 0.05), east + 0.5 * sway(4, 0.07), -kHeight_m + sway(5, 0.03)}};
  return X_NB * vision::MountPose({.position_m = Vector3d::Zero()});
}

Pose DrawnSurvey::Known(int i) const {
  constexpr double kOff_m = 0.5, kOff_rad = 0.5 * pi / 180;
  RandomStream random(RandomStream::Mix(seed_) + static_cast<std::uint64_t>(i), "known poses");
  const auto off = [&] { return Vector3d(random.Normal(), random.Normal(), random.Normal()); };
  Pose known = X_NC(i);
  known.p += kOff_m * off();
  known.R = known.R * ExpRotation(kOff_rad * off());
  return known;
}

cv::Mat DrawnSurvey::Draw(int i) const {
  const Pose X = X_NC(i);
  const Matrix3d R = X.R.toRotationMatrix();
  Matrix3d ground, picture;  // from the ray of a pixel to (north, east, 1), and on to the picture's pixels
  ground.row(0) = -X.p.z() * R.row(0) + X.p.x() * R.row(2);
  ground.row(1) = -X.p.z() * R.row(1) + X.p.y() * R.row(2);
  ground.row(2) = R.row(2);
  picture << 0, 1 / kGround_m, (kGroundSize.width - 1) / 2.0, -1 / kGround_m, 0,
      (kGroundSize.height - 1) / 2.0, 0, 0, 1;
  const Matrix3d H = picture * ground * kMosaicCamera.K().inverse() * FinePixels();
  cv::Mat map, fine;
  cv::eigen2cv(H, map);
  cv::warpPerspective(ground_, fine, map,
                      {kFinePixel * kMosaicCamera.width_px, kFinePixel * kMosaicCamera.height_px},
                      cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
  return Developed(fine, seed_, i);
}

Vector2d DrawnSurvey::InOrthographic(const Vector2d& north_east, double px_per_m) const {
  return {(north_east.y() + half_east_m()) * px_per_m, (half_north_m() - north_east.x()) * px_per_m};
}

cv::Mat DrawnSurvey::Orthographic(double px_per_m) const {
  const cv::Size size(static_cast<int>(2 * half_east_m() * px_per_m) + 1,
                      static_cast<int>(2 * half_north_m() * px_per_m) + 1);
  // From a pixel of the drawing to one of the picture, through finer ones.
  Matrix3d place, picture;
  place << 0, -1 / px_per_m, half_north_m(), 1 / px_per_m, 0, -half_east_m(), 0, 0, 1;
  picture << 0, 1 / kGround_m, (kGroundSize.width - 1) / 2.0, -1 / kGround_m, 0,
      (kGroundSize.height - 1) / 2.0, 0, 0, 1;
  cv::Mat map, fine, drawn;
  cv::eigen2cv(Matrix3d(picture * place * FinePixels()), map);
  cv::warpPerspective(ground_, fine, map, size * kFinePixel, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                      cv::BORDER_REFLECT);
  cv::resize(fine, drawn, size, 0, 0, cv::INTER_AREA);
  return drawn;
}

DrawnTurn::DrawnTurn(int images, std::uint64_t seed) : images_(images), seed_(seed) {
  RandomStream random(seed, "drawn turn");
  for (double& phase : phases_) phase = random.Uniform(0, 2 * pi);
  // Without a cut where the turn closes: the picture goes over into itself.
  constexpr int kOver = 256;
  const cv::Mat wide = Texture(kAroundSize + cv::Size(kOver, 0), seed);
  around_ = wide.colRange(0, kAroundSize.width).clone();
  for (int x = 0; x < kOver; ++x) {
    const double share = static_cast<double>(x) / kOver;
    cv::addWeighted(wide.col(x), share, wide.col(kAroundSize.width + x), 1 - share, 0, around_.col(x));
  }
}

Matrix3d DrawnTurn::R_WC(int i) const {
  constexpr double kBeyond = 20;  // degrees
  const auto sway = [&](int which, double per_image) {
    return std::sin(per_image * i + phases_[static_cast<std::size_t>(which)]);
  };
  const double yaw = Radians((360 + kBeyond) * i / std::max(1, images_ - 1)) + 0.01 * sway(0, 0.4);
  const Matrix3d R_NB = RotationFromTaitBryan({yaw, 0.03 * sway(1, 0.17), 0.03 * sway(2, 0.23)});
  Matrix3d R_WN;
  R_WN << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return R_WN * R_NB *
         vision::MountPose({.position_m = Vector3d::Zero(), .pitch_deg = 80}).R.toRotationMatrix();
}

cv::Mat DrawnTurn::Draw(int i) const {
  const cv::Size size(kFinePixel * kMosaicCamera.width_px, kFinePixel * kMosaicCamera.height_px);
  cv::Mat u(size, CV_32F), v(size, CV_32F), fine;
  const Matrix3d M = R_WC(i) * kMosaicCamera.K().inverse() * FinePixels();
  const double of_turn = kAroundSize.width / (2 * pi);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Vector3d w = M * Vector3d(x, y, 1);
      u.at<float>(y, x) = static_cast<float>(of_turn * std::atan2(w.x(), w.z()) + kAroundSize.width / 2.0);
      v.at<float>(y, x) = static_cast<float>(of_turn * std::atan2(w.y(), std::hypot(w.x(), w.z())) +
                                             kAroundSize.height / 2.0);
    }
  cv::remap(around_, fine, u, v, cv::INTER_LINEAR, cv::BORDER_WRAP);
  return Developed(fine, seed_, i);
}

}  // namespace kestrel::bench
