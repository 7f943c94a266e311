// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace kestrel {

// Where a number lies with some confidence; an end that is infinite: nothing is known on that side.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool Holds(double value) const { return low <= value && value <= high; }
  bool operator==(const Interval&) const = default;
};

// The probability of success after so many successes of so many runs: exact, that is, right at least as often
// as its level says, whatever the probability (Clopper and Pearson 1934). Of no runs: [0, 1].
Interval ShareInterval(std::int64_t successes, std::int64_t runs, double level = 0.95);

// The same on one side alone: at least this, at most this.
double ShareAtLeast(std::int64_t successes, std::int64_t runs, double level = 0.95);
double ShareAtMost(std::int64_t successes, std::int64_t runs, double level = 0.95);

}  // namespace kestrel
