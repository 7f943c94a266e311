// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/enhance/stabilisation/gyro_track.h"

// Clips of flat ground from a camera that shakes, whose path is known exactly, since the images are drawn from it.
namespace kestrel::bench {

struct ShakenClipOptions {
  std::string name;
  cv::Size size{640, 480};
  int images = 300;
  double rate_hz = 30;
  double forward_m_s = 0, turn_rad_s = 0, climb_m_s = 0;  // what is intended
  double wander_m = 0;                         // and to and fro, ahead in 10 s and to the side in 14 s
  double attitude_deg = 1, position_m = 0.03;  // deviations of what is not, in each direction
  double readout_s = 0;                        // from the first row to the last
};

class ShakenClip {
 public:
  ShakenClip(const ShakenClipOptions& options, std::uint64_t seed);

  // CV_8UC1, of the middle row at i / rate_hz. Each pixel is the mean of 2 x 2 samples, with noise of a deviation of 2
  // grey levels. Images may be drawn in any order.
  cv::Mat Draw(int i) const;
  double t_s(int i) const { return i / options_.rate_hz; }
  const ShakenClipOptions& options() const { return options_; }
  const vision::Pinhole& camera() const { return camera_; }

  // N: its origin on the ground, z down. The path that is intended, and that with the shakes, of 0.6 to 12 Hz.
  Pose Intended(double t_s) const;
  Pose X_NC(double t_s) const;
  // Where a point of the ground is seen at an instant, or by the row that sees it, which may lie off the image.
  Eigen::Vector2d SeenFrom(const Pose& X_NC, const Eigen::Vector3d& p_N) const;
  Eigen::Vector2d SeenByRows(int i, const Eigen::Vector3d& p_N) const;
  // The point of the ground that is seen there.
  Eigen::Vector3d Ground(const Pose& X_NC, const Eigen::Vector2d& uv) const;

  // At 200 Hz, over the whole clip, with noise and a bias as of a small MEMS gyro.
  std::vector<vision::GyroSample> Gyro() const;

 private:
  double Shake(int which, double t_s) const;

  ShakenClipOptions options_;
  std::uint64_t seed_;
  vision::Pinhole camera_;
  cv::Mat ground_;
  std::array<std::array<double, 8>, 6> phases_{};
};

}  // namespace kestrel::bench
