// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::vision {

// The normal equations of one Gauss-Newton step for N unknowns, gathered measurement by measurement. A residual
// is what was measured less what the model says; J is the derivative of what the model says.
template <typename Scalar, int N>
struct NormalEquations {
  using Vector = Eigen::Matrix<Scalar, N, 1>;
  using Matrix = Eigen::Matrix<Scalar, N, N>;

  Matrix H = Matrix::Zero();
  Vector g = Vector::Zero();
  double squares = 0, weight = 0;  // sums of the weighted squares of the residuals, and of the weights

  // One number.
  void Add(const Vector& J, Scalar residual, Scalar w) {
    H += w * J * J.transpose();
    g += w * residual * J;
    squares += w * residual * residual, weight += w;
  }
  // M numbers of weight 1.
  template <int M>
  void Add(const Eigen::Matrix<Scalar, M, N>& J, const Eigen::Matrix<Scalar, M, 1>& residual) {
    H.noalias() += J.transpose() * J;
    g.noalias() += J.transpose() * residual;
    squares += residual.squaredNorm(), weight += M;
  }
};

// Tukey's biweight of a residual in units of that from which on it counts nothing.
template <typename Scalar>
Scalar TukeyWeight(Scalar u) {
  return u * u < 1 ? (1 - u * u) * (1 - u * u) : 0;
}

}  // namespace kestrel::vision
