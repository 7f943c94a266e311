// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace kestrel::campaign {

// How a key varies.
struct Uniform {
  double low = 0, high = 1;
  bool operator==(const Uniform&) const = default;
};
struct LogUniform {  // its logarithm is uniform
  double low = 0.1, high = 1;
  bool operator==(const LogUniform&) const = default;
};
struct Normal {
  double mean = 0, sigma = 1;
  bool operator==(const Normal&) const = default;
};
struct TruncatedNormal {  // of mean and sigma before it is cut
  double mean = 0, sigma = 1, low = -1, high = 1;
  bool operator==(const TruncatedNormal&) const = default;
};
struct Choice {  // each as likely as the others; as YAML
  std::vector<std::string> values;
  bool operator==(const Choice&) const = default;
};
struct Grid {  // each of them in turn, with every other grid's
  std::vector<std::string> values;
  bool operator==(const Grid&) const = default;
};
using Distribution = std::variant<Uniform, LogUniform, Normal, TruncatedNormal, Choice, Grid>;

// The value below which the share u in [0, 1) of all lie, as --set takes it; numbers read back to the same
// bits. Of a grid: never asked.
std::string ValueAt(const Distribution& distribution, double u);

// The minimum and maximum values that can come, as --set takes them; of choices and grids all of them; of a
// normal, which has none, the numbers 10 sigma off.
std::vector<std::string> Extremes(const Distribution& distribution);

}  // namespace kestrel::campaign
