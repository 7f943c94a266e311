// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kestrel::mission {

// What the scenario asks of a metric, which must be at least, or at most, the limit for the run to pass.
struct MetricLimit {
  std::string metric;
  double limit = 0;
  bool at_least = false;
};

// What a figure of a flight says beside its data.
struct FigureText {
  std::string title;  // the scenario and its seed
  std::vector<MetricLimit> limits = {};
};

}  // namespace kestrel::mission
