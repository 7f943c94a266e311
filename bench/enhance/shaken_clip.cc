// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/shaken_clip.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "base/random.h"
#include "bench/planar/planar_pictures.h"
#include "geometry/tait_bryan.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHeight_m = 20, kGround_m_px = 0.025;
constexpr int kGround_px = 2560;  // it repeats itself, mirrored
constexpr int kFine = 2;
constexpr double kNoise_grey = 2;
// Gusts and the mount's vibration, and the deviation of each relative to all.
constexpr std::array<double, 8> kShakes_hz = {0.63, 0.97, 1.43, 2.1, 3.3, 5.2, 8.1, 11.9};
constexpr std::array<double, 8> kShakes = {0.35, 0.5, 0.5, 0.4, 0.35, 0.2, 0.15, 0.15};

}  // namespace

ShakenClip::ShakenClip(const ShakenClipOptions& options, std::uint64_t seed)
    : options_(options), seed_(seed) {
  RandomStream random(seed, "shaken clip " + options.name);
  for (auto& of : phases_)
    for (double& phase : of) phase = random.Uniform(0, 2 * std::numbers::pi);
  ground_ = Blotches({kGround_px, kGround_px}, 4, 22, random.Bits());
  const double f_px = 0.95 * options.size.width;
  camera_ = {options.size.width,
             options.size.height,
             f_px,
             f_px,
             (options.size.width - 1) / 2.0,
             (options.size.height - 1) / 2.0};
}

double ShakenClip::Shake(int which, double t_s) const {
  double sum = 0;
  for (std::size_t k = 0; k < kShakes.size(); ++k)
    sum += kShakes[k] * std::numbers::sqrt2 *
           std::sin(2 * std::numbers::pi * kShakes_hz[k] * t_s + phases_[static_cast<std::size_t>(which)][k]);
  return sum;
}

Pose ShakenClip::Intended(double t_s) const {
  // Looks down: z of C is z of N; its top is forward.
  const double yaw = options_.turn_rad_s * t_s;
  const double ahead_m = options_.wander_m * std::sin(2 * std::numbers::pi * t_s / 10),
               aside_m = options_.wander_m * std::sin(2 * std::numbers::pi * t_s / 14);
  const Vector3d p(options_.forward_m_s * t_s + ahead_m, aside_m, -kHeight_m - options_.climb_m_s * t_s);
  Eigen::Matrix3d look;  // x of C to the right, y backward
  look << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return {HeadingRotation(yaw) * Eigen::Quaterniond(look), p};
}

Pose ShakenClip::X_NC(double t_s) const {
  const Pose intended = Intended(t_s);
  const double a = Radians(options_.attitude_deg);
  const Vector3d turn(a * Shake(0, t_s), a * Shake(1, t_s), a * Shake(2, t_s));
  const Vector3d shift(Shake(3, t_s), Shake(4, t_s), Shake(5, t_s));
  return {intended.R * ExpRotation(turn), intended.p + options_.position_m * shift};
}

Vector2d ShakenClip::SeenFrom(const Pose& X_NC, const Vector3d& p_N) const {
  const Vector3d p_C = X_NC.Inverse() * p_N;
  return (camera_.K() * p_C).hnormalized();
}

Vector2d ShakenClip::SeenByRows(int i, const Vector3d& p_N) const {
  Vector2d uv = SeenFrom(X_NC(t_s(i)), p_N);
  for (int step = 0; step < 20; ++step) {
    const double row = uv.y() / (options_.size.height - 1) - 0.5;
    uv = SeenFrom(X_NC(t_s(i) + options_.readout_s * row), p_N);
  }
  return uv;
}

Vector3d ShakenClip::Ground(const Pose& X_NC, const Vector2d& uv) const {
  const Vector3d ray_N = X_NC.R * (camera_.K().inverse() * uv.homogeneous());
  return X_NC.p - X_NC.p.z() / ray_N.z() * ray_N;
}

cv::Mat ShakenClip::Draw(int i) const {
  const int width = kFine * options_.size.width, height = kFine * options_.size.height;
  cv::Mat map(height, width, CV_32FC2), fine, seen;
  for (int y = 0; y < height; ++y) {
    const double v = (y + 0.5) / kFine - 0.5;
    const Pose X = X_NC(t_s(i) + options_.readout_s * (v / (options_.size.height - 1) - 0.5));
    const Eigen::Matrix3d ray = X.R.toRotationMatrix() * camera_.K().inverse();
    const Vector3d first = ray * Vector3d(0.5 / kFine - 0.5, v, 1), step = ray.col(0) / kFine;
    auto* at = map.ptr<cv::Vec2f>(y);
    for (int x = 0; x < width; ++x) {
      const Vector3d d = first + x * step;
      const double s = -X.p.z() / d.z() / kGround_m_px;
      at[x] = {static_cast<float>(X.p.x() / kGround_m_px + s * d.x() + kGround_px / 2.0),
               static_cast<float>(X.p.y() / kGround_m_px + s * d.y() + kGround_px / 2.0)};
    }
  }
  cv::remap(ground_, fine, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  cv::resize(fine, seen, options_.size, 0, 0, cv::INTER_AREA);
  cv::Mat noise(seen.size(), CV_32FC1), result;
  cv::RNG rng(RandomStream::Mix(seed_ ^ RandomStream::Mix(static_cast<std::uint64_t>(i) + 7)) | 1);
  rng.fill(noise, cv::RNG::NORMAL, 0, kNoise_grey);
  cv::add(seen, noise, result, cv::noArray(), CV_8U);
  return result;
}

std::vector<vision::GyroSample> ShakenClip::Gyro() const {
  constexpr double kRate_hz = 200, kNoise_deg_s = 0.1, kBias_deg_s = 0.3, kStep_s = 1e-4, kBeyond_s = 0.1;
  RandomStream random(seed_, "shaken gyro");
  Vector3d bias;
  for (double& b : bias) b = Radians(kBias_deg_s) * random.Normal();
  std::vector<vision::GyroSample> samples;
  const double end_s = t_s(options_.images - 1) + kBeyond_s;
  for (double t = -kBeyond_s; t < end_s; t += 1 / kRate_hz) {
    const Vector3d w = LogRotation(X_NC(t - kStep_s).R.conjugate() * X_NC(t + kStep_s).R) / (2 * kStep_s);
    samples.push_back(
        {t, w + bias + Radians(kNoise_deg_s) * Vector3d(random.Normal(), random.Normal(), random.Normal())});
  }
  return samples;
}

}  // namespace kestrel::bench
