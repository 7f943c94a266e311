// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace kestrel::mission {

// A number that a flight is judged by.
struct Metric {
  std::string name;         // with its unit, where that is not 1
  std::string unit;         // m, deg, m/s; 1 of a share, a count and a truth
  std::string description;  // one sentence, without a full stop
  // Between these it lies, whatever the flight.
  double low = 0, high = std::numeric_limits<double>::infinity();
};

inline std::vector<std::string> NamesOf(const std::vector<Metric>& metrics) {
  std::vector<std::string> names;
  for (const Metric& metric : metrics) names.push_back(metric.name);
  return names;
}

}  // namespace kestrel::mission
