// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/row_warps.h"

#include <Eigen/LU>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace kestrel::vision {

std::vector<Eigen::Matrix3d> RowWarps(const std::vector<Eigen::Matrix3d>& to, double readout) {
  constexpr int kTimes = 9;
  const int side = static_cast<int>(to.size() / 2);
  std::vector<Eigen::Matrix3d> warps;
  for (int i = 0; i < kTimes; ++i) {
    const double middle = -readout * (i / (kTimes - 1.0) - 0.5);  // seen from this row
    Eigen::Matrix3d to_middle = Eigen::Matrix3d::Zero();
    double sum = 0;
    for (int k = -side; k <= side; ++k) {
      const double x = std::numbers::pi * (middle - k), window = std::cos(x / (2 * (side + 1)));
      const double weight = (std::abs(x) < 1e-9 ? 1 : std::sin(x) / x) * window * window;
      const Eigen::Matrix3d& of = to[static_cast<std::size_t>(side + k)];
      to_middle += weight / of(2, 2) * of, sum += weight;
    }
    warps.emplace_back((to_middle / sum).inverse());
  }
  return warps;
}

}  // namespace kestrel::vision
