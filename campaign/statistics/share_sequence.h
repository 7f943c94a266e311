// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "base/share_interval.h"

namespace kestrel::campaign {

// The probability of success after so many successes of so many runs, by intervals that hold it after every
// run at once with the level's probability: however often one looks, and whenever one stops because of what
// one saw, the interval is right as often as it says. Those of ShareInterval are not then.
//
// Against p stands the mixture of all probabilities, weighted by a beta distribution of 1/2 and 1/2. Were p
// true, its likelihood over p's would be a martingale that begins at 1, and which comes to 1 / (1 - level)
// with probability 1 - level at most (Ville 1939; Robbins 1970, Statistical methods related to the law of the
// iterated logarithm): the interval is of the p against which it has not.
//
// It holds for runs that are exchangeable, counted in the order of their rows: those of a grid are not, and
// those that happen to have ended first are not either, for failures may take less time.
Interval ShareSequence(std::int64_t successes, std::int64_t runs, double level = 0.95);

// Whether that interval is no wider than 2 x half_width: the rule of --stop-when.
bool NarrowEnough(std::int64_t successes, std::int64_t runs, double half_width, double level = 0.95);

}  // namespace kestrel::campaign
