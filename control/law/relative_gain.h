// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Bristol's relative gain array, thesis 5.4, eqs. (5.22) and (5.23): which input should control which feature
// when each has a loop of its own, and how much the loops disturb each other.
namespace kestrel::control {

struct RelativeGains {
  // L (x) (L^-1)^T, element by element: a row for each feature, a column for each input. The gain of a loop
  // with the others open over that with the others perfect; rows and columns sum to 1, and no choice of units
  // changes it. Near 1: the pair does not mind the others. Negative: closing the others turns its sign.
  Eigen::MatrixXd gains;
  std::vector<int> input_of;  // the best input for each feature, each used once
  double distance = 0;        // sum of |gains - pairing|: 0 where the loops do not disturb each other
};

// None unless L is square, finite and can be inverted; at most eight features, as all pairings are tried. The
// best has its gains nearest to 1 and, where there is one, no gain that is not positive.
std::optional<RelativeGains> RelativeGainArray(const Eigen::MatrixXd& L);

// As a small table, a line for each feature, the pairing marked by stars.
std::string RelativeGainTable(const RelativeGains& rga, std::span<const std::string> features,
                              std::span<const std::string> inputs);

}  // namespace kestrel::control
