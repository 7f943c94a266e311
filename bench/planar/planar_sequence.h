// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"

// Sequences of a flat picture before a background whose homographies are known exactly, since the images are
// drawn from them. The factors are those of POT-210 (P. Liang et al., "Planar Object Tracking in the Wild: A
// Benchmark", ICRA 2018), each by itself and then all together.
namespace kestrel::bench {

enum class PlanarFactor {
  kScale,
  kRotation,
  kPerspective,
  kMotionBlur,
  kOcclusion,
  kOutOfView,
  kUnconstrained
};
inline constexpr std::array kPlanarFactors = {PlanarFactor::kScale,        PlanarFactor::kRotation,
                                              PlanarFactor::kPerspective,  PlanarFactor::kMotionBlur,
                                              PlanarFactor::kOcclusion,    PlanarFactor::kOutOfView,
                                              PlanarFactor::kUnconstrained};
const char* NameOf(PlanarFactor factor);

// T: of the picture, as of a pad (vision/landmark/pad_reference.h): its middle, x up in it, y to its right.
inline constexpr double kPlanarLength_m = 0.9, kPlanarWidth_m = 1.2;
inline constexpr double kPlanarRate_hz = 30;
inline constexpr int kPlanarFrames = 180;
inline const vision::Pinhole kPlanarCamera{640, 480, 810.81, 810.81, 319.5, 239.5};

// Where the four corners of the picture are, in T, m, clockwise from its top left.
std::array<Eigen::Vector2d, 4> PlanarCorners();

struct PlanarFrame {
  cv::Mat image;        // CV_8UC1
  Eigen::Matrix3d H_w;  // from T, m, to the image, at the middle of the exposure
  double visible = 1;   // share of the picture's area that is in the image and not covered
};

class PlanarSequence {
 public:
  // picture: CV_8UC1, filled to its rim.
  PlanarSequence(const cv::Mat& picture, PlanarFactor factor, std::uint64_t seed);

  // Each pixel is the mean of 2 x 2 samples, and of 12 instants where there is motion blur, with noise of a
  // standard deviation of 2 grey levels. Frames may be drawn in any order.
  PlanarFrame Draw(int frame) const;

  Pose X_CT(double t_s) const;  // of the picture in the camera; t_s: from 0, the middle of the first exposure

 private:
  double Wave(int which, double hz, double t_s) const;
  double Cover(
      double t_s) const;  // where the sheet's right edge is, as a share of the picture's width from its left
  cv::Mat Instant(double t_s) const;

  PlanarFactor factor_;
  std::uint64_t seed_;
  std::vector<cv::Mat> picture_, background_, sheet_;  // halves of each other, the finest first
  std::array<double, 12> phases_{};
  double side_ = 1;  // to which it goes out first
};

}  // namespace kestrel::bench
