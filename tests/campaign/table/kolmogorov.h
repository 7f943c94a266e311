// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kestrel::campaign {

// The greatest distance of a sample's distribution from one given, times the root of its size: above 1.95 of
// one sample in a thousand (Kolmogorov's limit).
inline double KolmogorovDistance(std::vector<double> sample, const auto& cdf) {
  std::sort(sample.begin(), sample.end());
  const auto n = static_cast<double>(sample.size());
  double distance = 0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double f = cdf(sample[i]), rank = static_cast<double>(i);
    distance = std::max({distance, f - rank / n, (rank + 1) / n - f});
  }
  return distance * std::sqrt(n);
}

}  // namespace kestrel::campaign
