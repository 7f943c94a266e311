// SPDX-License-Identifier: Apache-2.0
#include "base/share_interval.h"

#include <boost/math/special_functions/beta.hpp>

namespace kestrel {

// P(X >= k) of a binomial of n and p is I_p(k, n - k + 1): its value 1 - level is at the bound.
double ShareAtLeast(std::int64_t successes, std::int64_t runs, double level) {
  if (successes == 0) return 0;
  return boost::math::ibeta_inv(static_cast<double>(successes), static_cast<double>(runs - successes + 1),
                                1 - level);
}

double ShareAtMost(std::int64_t successes, std::int64_t runs, double level) {
  return 1 - ShareAtLeast(runs - successes, runs, level);
}

Interval ShareInterval(std::int64_t successes, std::int64_t runs, double level) {
  const double each = (1 + level) / 2;
  return {ShareAtLeast(successes, runs, each), ShareAtMost(successes, runs, each)};
}

}  // namespace kestrel
