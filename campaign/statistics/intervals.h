// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "base/share_interval.h"

namespace kestrel::campaign {

// A number from samples and where the true one lies.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  Interval interval;
};

// The mean, with Student's interval corrected for the skewness of the samples (the cubic transformation of
// Hall 1992, On the removal of skewness by transformation, with Student's quantile for the normal one): what
// flights miss by is skewed, and Student's own interval then lies too low. Of symmetric samples they are the
// same. An end beyond all samples is not given (infinite): of few, or of shares near their
// bounds, the method says there what no sample supports, and cannot be.
Estimate MeanOf(const std::vector<double>& samples, double level = 0.95);

// The quantile q in (0, 1), with the interval between two of the samples that holds it whatever they are
// drawn from (the order statistics of which the binomial distribution says so, equal tails). Infinite where
// the samples are too few to say. Samples may be infinite, but must be numbers.
Estimate QuantileOf(std::vector<double> samples, double q, double level = 0.95);

}  // namespace kestrel::campaign
