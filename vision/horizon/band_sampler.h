// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// Directions about a vertical: azimuth from `forward` towards `right`, elevation above their plane.
struct Horizontal {
  Eigen::Vector3d forward, right, down;  // orthonormal, in C

  Eigen::Vector3d Direction(double azimuth, double elevation) const;
  double Azimuth(const Eigen::Vector3d& ray_C) const;
  double Elevation(const Eigen::Vector3d& ray_C) const;
};
// forward: the part of the hint that lies across down; any, where the hint is vertical.
Horizontal HorizontalAbout(const Eigen::Vector3d& down_C, const Eigen::Vector3d& forward_hint_C);

// Even steps of azimuth all around, and of elevation from the lowest upwards.
struct BandGrid {
  int azimuths = 0, elevations = 0;
  double lowest = 0, step = 0;  // rad
  double Azimuth(int i) const { return 2 * M_PI * i / azimuths; }
  double Elevation(int j) const { return lowest + step * j; }
};

// What is seen in the directions of a grid: a row per azimuth.
struct BandSamples {
  cv::Mat colour;  // CV_32FC3
  cv::Mat shown;   // CV_8UC1, 0 where the lens shows nothing or the mask forbids
};

// Reads an image (CV_8UC3) in the directions of a band. The image may be a reduction of the camera's by whole
// pixels (1, 2, 4). Projects only a lattice a few steps wide and lies between its knots: to better than 0.05
// px for steps below a degree.
class BandSampler {
 public:
  // forbidden: CV_8UC1 of the camera's size, not 0 where the aircraft itself is seen; or empty.
  BandSampler(CameraModel camera, cv::Mat forbidden);

  BandSamples Read(const cv::Mat& image, int reduction, const Horizontal& horizontal,
                   const BandGrid& grid) const;
  const CameraModel& camera() const { return camera_; }
  const cv::Mat& forbidden() const { return forbidden_; }

 private:
  CameraModel camera_;
  cv::Mat forbidden_;
};

}  // namespace kestrel::vision
