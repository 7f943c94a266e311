// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace kestrel::mission {

// For the root mean square of errors, one after the other.
struct MeanSquare {
  double sum = 0;
  int count = 0;
  void Add(double e) { sum += e * e, ++count; }
  double Root() const { return std::sqrt(sum / count); }
};

}  // namespace kestrel::mission
