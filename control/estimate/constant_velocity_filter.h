// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::control {

// Kalman filter of a position that moves at constant velocity, thesis 4.6 to 4.8. The process noise is that
// of a white acceleration, whose discrete covariance follows from the model (the thesis sets Q by trial).
class ConstantVelocityFilter {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;  // (position, m; velocity, m/s)
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  // acceleration: its spectral density's root, m/s^2 per root hertz.
  ConstantVelocityFilter(const Eigen::Vector3d& position, double position_sigma,
                         const Eigen::Vector3d& velocity, double velocity_sigma, double acceleration);

  void Predict(double dt_s);                                                         // eq. (4.6), (4.7)
  void Correct(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);  // eq. (4.8)

  Eigen::Vector3d position() const { return x_.head<3>(); }
  Eigen::Vector3d velocity() const { return x_.tail<3>(); }
  const Matrix6& covariance() const { return P_; }

 private:
  Vector6 x_;
  Matrix6 P_;
  double acceleration_;
};

}  // namespace kestrel::control
