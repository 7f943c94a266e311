// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/path_weights.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace kestrel::vision {

using Eigen::MatrixXd;
using Eigen::VectorXd;

PathWeights::PathWeights(int before, int after, double cutoff) : before_(before), after_(after) {
  constexpr double kStop = 2.5, kFloor = 1e-3;  // shakes below kStop: what measuring a path leaves open
  const int distances = 2 * (before + after + 1), steps = 2 * distances + 400;
  const double stop = std::min(0.45, kStop * cutoff), half = std::sin(std::numbers::pi * cutoff) / 2;
  shakes_.assign(static_cast<std::size_t>(distances), 0), path_ = shakes_;
  for (int i = 0; i < steps; ++i) {
    const double f = 0.5 * (i + 0.5) / steps, shakes = (f < stop ? 0 : 1) + kFloor,
                 path = std::pow(half / std::sin(std::numbers::pi * f), 4);
    for (int k = 0; k < distances; ++k) {
      const double wave = std::cos(2 * std::numbers::pi * f * k) / steps;
      shakes_[static_cast<std::size_t>(k)] += shakes * wave,
          path_[static_cast<std::size_t>(k)] += path * wave;
    }
  }
  whole_ = Foretell(before + after + 1, {before}).row(0).transpose();
}

// Row r: the weights of places 0 to known - 1 for the path at places[r].
MatrixXd PathWeights::Foretell(int known, const std::vector<int>& places) const {
  const int order = std::min(2, known), n = known + order, wanted = static_cast<int>(places.size());
  const double middle = (known - 1) / 2.0;
  const auto at = [](const std::vector<double>& of, int distance) {
    return of[static_cast<std::size_t>(std::abs(distance))];
  };
  MatrixXd A = MatrixXd::Zero(n, n), b = MatrixXd::Zero(n, wanted);
  const auto even = [&](int m, double place) { return m == 0 ? 1 : (place - middle) / known; };
  for (int i = 0; i < known; ++i) {
    for (int k = 0; k < known; ++k) A(i, k) = at(shakes_, i - k) + at(path_, i - k);
    for (int m = 0; m < order; ++m) A(i, known + m) = A(known + m, i) = even(m, i);
  }
  for (int r = 0; r < wanted; ++r) {
    const int place = places[static_cast<std::size_t>(r)];
    for (int i = 0; i < known; ++i) b(i, r) = at(path_, i - place);
    for (int m = 0; m < order; ++m) b(known + m, r) = even(m, place);
  }
  return A.partialPivLu().solve(b).topRows(known).transpose();
}

const MatrixXd& PathWeights::Beyond(int known) {
  auto [at, is_new] = beyond_.try_emplace(known);
  if (is_new) {
    std::vector<int> places;
    for (int r = 0; r < std::max(before_, after_); ++r) places.push_back(-(r + 1));
    at->second = Foretell(known, places);
  }
  return at->second;
}

const VectorXd& PathWeights::Of(int before, int after) {
  auto [at, is_new] = parts_.try_emplace({before, after});
  VectorXd& part = at->second;
  if (!is_new) return part;
  const int known = before + after + 1, earlier = before_ - before, later = after_ - after;
  part = whole_.segment(earlier, known);
  if (earlier > 0) {
    const int from = std::min(after_ + 1, known);
    part.head(from) += Beyond(from).topRows(earlier).transpose() * whole_.head(earlier).reverse();
  }
  if (later > 0) {
    const int from = std::min(before_ + 1, known);
    part.tail(from) += (Beyond(from).topRows(later).transpose() * whole_.tail(later)).reverse();
  }
  return part;
}

}  // namespace kestrel::vision
