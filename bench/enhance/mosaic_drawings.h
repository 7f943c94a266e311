// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"

// Images of a survey and of a turn whose camera is known exactly, since they are drawn from it: each pixel is the mean
// of 2 x 2 samples, with noise of a deviation of 2 grey levels. 640 x 480 pixels, CV_8UC1. Images may be drawn in any
// order.
namespace kestrel::bench {

inline const vision::Pinhole kMosaicCamera{640, 480, 810.81, 810.81, 319.5, 239.5};

// Flat ground from 40 m, in lanes that overlap by half, there and back. The camera sways by some degrees and by half a
// metre, and climbs by a metre.
class DrawnSurvey {
 public:
  static constexpr int kLanes = 6;
  static constexpr double kHeight_m = 40;

  // images: of all lanes together.
  DrawnSurvey(int images, std::uint64_t seed);

  int images() const { return images_; }
  cv::Mat Draw(int i) const;
  Pose X_NC(int i) const;  // N: its origin on the ground
  // What a navigation knows of it: off by half a metre and half a degree in each direction, each time anew.
  Pose Known(int i) const;

  // The ground from straight above, of so many pixels to a metre, north up: where a place, north and east, m, is in it.
  cv::Mat Orthographic(double px_per_m) const;
  Eigen::Vector2d InOrthographic(const Eigen::Vector2d& north_east, double px_per_m) const;
  double half_north_m() const { return 72; }
  double half_east_m() const { return 48; }

 private:
  int images_;
  std::uint64_t seed_;
  cv::Mat ground_;
  std::array<double, 6> phases_{};
};

// A turn on the spot by 360 degrees and a little more, looking down by ten degrees, swaying.
class DrawnTurn {
 public:
  DrawnTurn(int images, std::uint64_t seed);

  int images() const { return images_; }
  cv::Mat Draw(int i) const;
  Eigen::Matrix3d R_WC(int i) const;  // W: x east, y down, z north

 private:
  int images_;
  std::uint64_t seed_;
  cv::Mat around_;  // columns: azimuths of a whole turn; rows: elevations of a quarter of it
  std::array<double, 4> phases_{};
};

}  // namespace kestrel::bench
