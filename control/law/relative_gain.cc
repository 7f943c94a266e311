// SPDX-License-Identifier: Apache-2.0
#include "control/law/relative_gain.h"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace kestrel::control {
namespace {

constexpr double kNotPositive = 1e6;  // more than any sum of distances that matters

double Cost(const Eigen::MatrixXd& gains, const std::vector<int>& input_of) {
  double cost = 0;
  for (std::size_t i = 0; i < input_of.size(); ++i) {
    const double gain = gains(static_cast<Eigen::Index>(i), input_of[i]);
    cost += std::abs(gain - 1) + (gain > 0 ? 0 : kNotPositive);
  }
  return cost;
}

}  // namespace

std::optional<RelativeGains> RelativeGainArray(const Eigen::MatrixXd& L) {
  if (L.rows() != L.cols() || L.rows() == 0 || L.rows() > 8 || !L.allFinite()) return std::nullopt;
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(L);
  if (!lu.isInvertible()) return std::nullopt;
  RelativeGains rga;
  rga.gains = L.cwiseProduct(lu.inverse().transpose());  // eq. (5.22)
  if (!rga.gains.allFinite()) return std::nullopt;

  std::vector<int> tried(static_cast<std::size_t>(L.rows()));
  std::iota(tried.begin(), tried.end(), 0);
  double least = std::numeric_limits<double>::infinity();
  do {
    const double cost = Cost(rga.gains, tried);
    if (cost < least) least = cost, rga.input_of = tried;
  } while (std::next_permutation(tried.begin(), tried.end()));

  Eigen::MatrixXd rest = rga.gains;
  for (std::size_t i = 0; i < rga.input_of.size(); ++i) {
    rest(static_cast<Eigen::Index>(i), rga.input_of[i]) -= 1;
  }
  rga.distance = rest.cwiseAbs().sum();
  return rga;
}

std::string RelativeGainTable(const RelativeGains& rga, std::span<const std::string> features,
                              std::span<const std::string> inputs) {
  assert(static_cast<Eigen::Index>(features.size()) == rga.gains.rows());
  assert(static_cast<Eigen::Index>(inputs.size()) == rga.gains.cols());
  std::string table;
  const auto add = [&](const char* format, const char* text) {
    char cell[64];
    std::snprintf(cell, sizeof cell, format, text);
    table += cell;
  };
  add("%-10.20s", "");
  for (const std::string& input : inputs) add(" %10.20s", input.c_str());
  table += "\n";
  for (std::size_t i = 0; i < features.size(); ++i) {
    add("%-10.20s", features[i].c_str());
    for (std::size_t j = 0; j < inputs.size(); ++j) {
      const double gain = rga.gains(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      char number[32];
      // + 0.0: a zero has no sign here
      std::snprintf(number, sizeof number, "%s%.3f", rga.input_of[i] == static_cast<int>(j) ? "*" : "",
                    std::round(gain * 1000) / 1000 + 0.0);
      add(" %10.30s", number);
    }
    table += "\n";
  }
  return table;
}

}  // namespace kestrel::control
