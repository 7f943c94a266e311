// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_set.h"

namespace kestrel::control {

double Membership(const FuzzySet& set, double x) {
  const double a = set.corners[0], b = set.corners[1], c = set.corners[2], d = set.corners[3];
  if (!(a <= x && x <= d)) return 0;
  if (x < b) return (x - a) / (b - a);
  if (x > c) return (d - x) / (d - c);
  return 1;
}

}  // namespace kestrel::control
