// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/pose.h"
#include "tests/vision/landmark/pose_difference.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/plane/homography.h"

// Poses of a pad of 1.19 m x 0.91 m before a camera, and the pixels of its points.
namespace kestrel::vision {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

inline const Pinhole kCamera{640, 480, 810, 790, 290, 255};

class DrawnPoses {
 public:
  explicit DrawnPoses(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  double Uniform(double low, double high) { return low + (high - low) * unit_(rng_); }
  Eigen::Vector2d Noise(double sigma) { return {sigma * Normal(), sigma * Normal()}; }
  // A pad below a camera that looks down to within 50 degrees, turned any way about.
  Pose PadPose() {
    const double azimuth = Angle();
    return PadPose(azimuth, Uniform(0, 0.87), 15);
  }
  // One of this tilt, nearer.
  Pose PadPose(double tilt) { return PadPose(Angle(), tilt, 8); }

 private:
  double Angle() { return Uniform(-std::numbers::pi, std::numbers::pi); }
  Pose PadPose(double azimuth, double tilt, double max_depth_m) {
    const Eigen::Quaterniond R_CT =
        ExpRotation(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
        ExpRotation({0, 0, Angle()});
    const Eigen::Vector3d ray = *kCamera.Ray({Uniform(150, 490), Uniform(120, 360)});
    return {R_CT, Uniform(2, max_depth_m) / ray.z() * ray};
  }

  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_;
};

// Points all over the pad with their pixels.
inline std::vector<PointPair> Grid(const Pose& X_CT, int side = 5) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < side; ++i) {
    for (int k = 0; k < side; ++k) {
      const Eigen::Vector2d on_pad(1.19 * (i / (side - 1.0) - 0.5), 0.91 * (k / (side - 1.0) - 0.5));
      pairs.push_back({on_pad, kCamera.Project(X_CT * Eigen::Vector3d(on_pad.x(), on_pad.y(), 0)).value()});
    }
  }
  return pairs;
}

inline std::vector<PointPair> Noisy(std::vector<PointPair> pairs, double sigma, DrawnPoses& random) {
  for (PointPair& pair : pairs) pair.to += random.Noise(sigma);
  return pairs;
}

// J^T J, with J the derivative of the pixels by the pose, as of PlanePose's covariance: by central differences.
inline Matrix6 NumericInformation(const std::vector<PointPair>& pairs, const Pose& X_CT) {
  constexpr double kStep = 1e-5;
  Matrix6 JtJ = Matrix6::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d p_T(pair.from.x(), pair.from.y(), 0);
    Eigen::Matrix<double, 2, 6> J;
    for (int k = 0; k < 6; ++k) {
      const Vector6 d = kStep * Vector6::Unit(k);
      const Pose plus{ExpRotation(d.tail<3>()) * X_CT.R, X_CT.p + d.head<3>()};
      const Pose minus{ExpRotation(-d.tail<3>()) * X_CT.R, X_CT.p - d.head<3>()};
      J.col(k) = (*kCamera.Project(plus * p_T) - *kCamera.Project(minus * p_T)) / (2 * kStep);
    }
    JtJ += J.transpose() * J;
  }
  return JtJ;
}

}  // namespace kestrel::vision
