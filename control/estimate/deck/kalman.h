// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::control {

// A linear Kalman filter of N numbers, of which one sum is measured at a time.
template <int N>
struct Kalman {
  Eigen::Matrix<double, N, 1> x = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> P = Eigen::Matrix<double, N, N>::Zero();

  void Predict(const Eigen::Matrix<double, N, N>& F, const Eigen::Matrix<double, N, N>& Q) {
    x = F * x;
    P = F * P * F.transpose() + Q;
  }
  // z = h x + noise of that variance.
  void Correct(const Eigen::Matrix<double, 1, N>& h, double z, double variance) {
    const Eigen::Matrix<double, N, 1> gain = P * h.transpose() / (h.dot(P * h.transpose()) + variance);
    x += gain * (z - h.dot(x));
    // Joseph's form keeps the covariance symmetric and positive
    const Eigen::Matrix<double, N, N> rest = Eigen::Matrix<double, N, N>::Identity() - gain * h;
    P = rest * P * rest.transpose() + gain * variance * gain.transpose();
  }
};

}  // namespace kestrel::control
