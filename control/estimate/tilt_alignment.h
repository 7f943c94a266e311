// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "geometry/pose.h"

// An autopilot knows "down" with a small noise and an error of a degree that hardly changes: accelerometer
// bias, a camera mounted askew. A camera over a level pad knows it without bias, but far from the pad, or
// with most of it hidden, only roughly. Each mends the other.
namespace kestrel::control {

// The slowly changing tilt between the autopilot's "down" and the pad's normal, both as unit vectors in the
// camera frame C. A Kalman filter of two angles.
class TiltAlignment {
 public:
  struct Options {
    double initial_deg = 1.5;  // deviation before the pad was first seen
    double drift_deg_per_root_s = 0.03;
    double autopilot_noise_deg = 0.15;  // short-term error of the autopilot's tilt
    double correlation_s = 1.5;         // time over which the errors of vision and autopilot stay alike
  };

  explicit TiltAlignment(const Options& options);

  void Predict(double dt_s);
  // normal_C: the pad's, by vision alone, whose two tilt angles have the given covariance (rotation vector in
  // C, rad^2). dt_s: since the last correction. Corrections that follow each other within the correlation
  // time count as one: the corners of a picture err the same way from frame to frame.
  void Correct(double dt_s, const Eigen::Vector3d& down_C, const Eigen::Vector3d& normal_C,
               const Eigen::Matrix3d& covariance);

  // The autopilot's "down", corrected; and the deviation of that, rad.
  Eigen::Vector3d Apply(const Eigen::Vector3d& down_C) const;
  double sigma() const;

 private:
  Options options_;
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();  // rotation about x and y of C, rad
  Eigen::Matrix2d P_;
};

// X_CT and its covariance after a measurement of the direction of T's z axis in C, with the deviation sigma,
// rad: a Kalman update of the pose, which moves its position with its tilt as their covariance says.
void FuseNormal(const Eigen::Vector3d& normal_C, double sigma, Pose& X_CT,
                Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace kestrel::control
