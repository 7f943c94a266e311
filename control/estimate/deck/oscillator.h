// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::control {

// A value that swings about zero, driven by white noise: x'' = -w^2 x - 2 d w x' + noise. What a ship does in a
// seaway, of which its own period is most.
struct Oscillator {
  double w = 0.8;         // rad/s
  double damping = 0.15;  // ratio, below 1: the less, the farther ahead it is predicted
  double sigma = 0.1;     // standard deviation of x where it has swung for long

  Eigen::Matrix2d Transition(double dt_s) const;  // of (x, x')
  // The covariance that the noise adds within dt; it and Transition keep Stationary as it is.
  Eigen::Matrix2d Noise(double dt_s) const;
  Eigen::Matrix2d Stationary() const;
};

}  // namespace kestrel::control
