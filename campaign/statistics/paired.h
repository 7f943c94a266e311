// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "campaign/statistics/intervals.h"

namespace kestrel::campaign {

// How the same rows ended in two campaigns.
struct PairedEnds {
  std::int64_t both = 0, only_a = 0, only_b = 0, neither = 0;  // that passed
  std::int64_t rows() const { return both + only_a + only_b + neither; }
};

// The probability that chance alone parts the two at least as much, were they alike: the exact test of
// McNemar, two-sided. Of no row that differs: 1.
double McNemar(const PairedEnds& ends);

// B's share of successes less A's, with the score interval of Tango 1998, Equivalence test and confidence
// interval for the difference in proportions for the paired-sample design.
Estimate ShareDifference(const PairedEnds& ends, double level = 0.95);

// Of the mean of differences, at least two, by Student's distribution.
Interval StudentInterval(const std::vector<double>& differences, double level = 0.95);

// A statistic of two samples, paired by their rows, and B's less A's.
struct PairedDifference {
  double a = 0, b = 0;
  Interval interval;  // of b - a, at 95 %
};
struct PairedDifferences {
  PairedDifference mean, median, quantile_95;
  Interval mean_stricter;  // of the mean's, at the level asked for
};

// Of the mean by Student's interval of the differences: of skewed and of symmetric ones alike it is right
// more often than the bootstrap's (percentiles, BCa, studentised). Of the median and the quantile by the
// bootstrap over pairs, percentiles as they come (Efron and Tibshirani 1993, chapter 13), which are rather
// too wide. The same seed gives the same bits. a and b: as many of each, at least two.
PairedDifferences DifferencesOf(const std::vector<double>& a, const std::vector<double>& b,
                                std::uint64_t seed, double stricter_level = 0.95, int resamples = 4000);

}  // namespace kestrel::campaign
