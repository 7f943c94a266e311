// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/share_sequence.h"

#include <cmath>
#include <numbers>

namespace kestrel::campaign {

Interval ShareSequence(std::int64_t successes, std::int64_t runs, double level) {
  if (runs == 0) return {0, 1};
  const double k = static_cast<double>(successes), m = static_cast<double>(runs - successes);
  // The mixture's likelihood of this very sequence: B(k + 1/2, m + 1/2) / B(1/2, 1/2), the latter being pi.
  const double mixture =
      std::lgamma(k + 0.5) + std::lgamma(m + 0.5) - std::lgamma(k + m + 1) - std::log(std::numbers::pi);
  const auto in = [&](double p) {
    const double likelihood = (k > 0 ? k * std::log(p) : 0) + (m > 0 ? m * std::log1p(-p) : 0);
    return likelihood > mixture + std::log(1 - level);
  };
  const auto edge = [&](double inside, double outside) {  // an end that is in is the end
    if (in(outside)) return outside;
    for (int i = 0; i < 60; ++i) {
      const double middle = (inside + outside) / 2;
      (in(middle) ? inside : outside) = middle;
    }
    return outside;
  };
  const double share = k / (k + m);
  return {edge(share, 0), edge(share, 1)};
}

bool NarrowEnough(std::int64_t successes, std::int64_t runs, double half_width, double level) {
  const Interval interval = ShareSequence(successes, runs, level);
  return interval.high - interval.low <= 2 * half_width;
}

}  // namespace kestrel::campaign
