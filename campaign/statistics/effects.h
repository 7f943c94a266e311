// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/run_result.h"
#include "campaign/statistics/intervals.h"
#include "campaign/table/sample_table.h"

namespace kestrel::campaign {

// The correlation of the ranks of x and y (Spearman), ties having the mean of their ranks; the interval by
// Fisher's transformation with the variance of Bonett and Wright 2000. None: fewer than 10 pairs, or one of
// the two does not vary.
std::optional<Estimate> RankCorrelation(const std::vector<double>& x, const std::vector<double>& y,
                                        double level = 0.95);

// The share of the variance of y that is between groups, less what chance puts there (epsilon squared, Kelley
// 1935): the correlation ratio of a choice, and its first-order Sobol index. The interval is by the index's
// influence function. The value is not clipped and may be below zero by chance; its interval is within [0,
// 1]. None: fewer than 10 samples, one group, as many groups as samples, or a y that does not vary.
std::optional<Estimate> ShareBetweenGroups(const std::vector<std::size_t>& groups,
                                           const std::vector<double>& y, double level = 0.95);

// The first-order Sobol index of x from samples as they are, Var(E[y | x]) / Var(y): the share of y's
// variance that goes with x alone. E[y | x] is a line in the ranks of x for each of 2 to 16 groups of
// neighbours, of some 20 samples: a wave of x with more periods over its range than a quarter of the groups
// is estimated too low. None: fewer than 50 samples, or a y that does not vary.
std::optional<Estimate> FirstOrderIndex(const std::vector<double>& x, const std::vector<double>& y,
                                        double level = 0.95);

// What a key that varies does to a metric, over the runs that have the metric.
struct Effect {
  std::string key;
  std::string of;                            // a metric, or "success", which is 0 or 1
  std::int64_t runs = 0;                     // that have it
  bool numeric = false;                      // otherwise a choice
  std::optional<Estimate> rank_correlation;  // of numeric keys
  // First-order Sobol index, at least 0. With keys that are drawn correlated, it holds what goes with the
  // others too.
  std::optional<Estimate> first_order;
};

// Of every key that varies (but the seed) on each of these metrics, in the order of both; "success" is one.
// Without both estimates there is no effect to show, and none is listed; of success there are none with fewer
// than five runs of either end. Total-order indices are not here: they ask for runs of another design, in
// which one key is drawn anew while the others stay.
std::vector<Effect> EffectsOf(const SampleTable& table, const std::vector<RunResult>& results,
                              const std::vector<std::string>& metrics);

// The number that a text is from its beginning to its end, if it is one.
std::optional<double> NumberIn(const std::string& text);

}  // namespace kestrel::campaign
