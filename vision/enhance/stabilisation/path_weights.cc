// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/path_weights.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <vector>

namespace kestrel::vision {

Eigen::VectorXd PathWeights(int before, int after, double cutoff, int order) {
  const int n = before + after + 1;
  std::vector<double> difference = {1};  // of that order: binomials of alternating sign
  for (int k = 0; k < order; ++k) {
    difference.push_back(0);
    for (std::size_t i = difference.size() - 1; i > 0; --i) difference[i] -= difference[i - 1];
  }
  const double lambda = std::pow(2 * std::sin(std::numbers::pi * cutoff), -2.0 * order);
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (int row = 0; row + order < n; ++row)
    for (int i = 0; i <= order; ++i)
      for (int k = 0; k <= order; ++k)
        A(row + i, row + k) +=
            lambda * difference[static_cast<std::size_t>(i)] * difference[static_cast<std::size_t>(k)];
  return A.ldlt().solve(Eigen::VectorXd::Unit(n, before));  // symmetric: its column is its row
}

}  // namespace kestrel::vision
