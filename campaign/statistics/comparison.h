// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"
#include "campaign/statistics/metric_aims.h"
#include "campaign/statistics/paired.h"

namespace kestrel::campaign {

struct CampaignResults {
  CampaignIdentity identity;
  std::vector<RunResult> results;
};

// Of B, against A.
enum class Verdict { kBetter, kWorse, kNotShown };

// A metric over the rows that have it in both.
struct MetricComparison {
  std::string name;
  std::optional<Better> better;
  std::int64_t pairs = 0, only_a = 0, only_b = 0;  // rows that have it in both, in one alone
  PairedDifferences differences;
  // Whether the mean differs, in the direction that counts. Over all metrics with such a direction together
  // no difference is seen where there is none with 95 % confidence (Bonferroni), and over the others
  // likewise: each is judged at a stricter level than the interval shown.
  Verdict verdict = Verdict::kNotShown;
};

struct Comparison {
  std::vector<std::string> differs;  // in what the two differ: "wind.mean_m_s: 3 in A, 5 in B"
  PairedEnds ends;                   // of the rows that both have results of
  std::int64_t rows_only_a = 0, rows_only_b = 0;
  Estimate success;   // B's share less A's
  double chance = 1;  // McNemar's
  Verdict success_verdict = Verdict::kNotShown;
  std::vector<MetricComparison> metrics;
  // By success, where that differs; otherwise by the metrics, if none speaks against the others.
  Verdict verdict = Verdict::kNotShown;
  std::string sentence;  // the same in words
};

// Two campaigns of which the tables agree in every key and row; what else they set may differ. metrics: those
// to compare; empty: the ones that either lists. Throws InputError: where the tables differ, a metric that
// neither has, no row that both have a result of.
Comparison Compare(const CampaignResults& a, const CampaignResults& b, std::vector<std::string> metrics = {},
                   std::uint64_t seed = 1, int resamples = 4000);

std::string ToText(const Comparison& comparison);

// JSON, for other tools: differs, rows {both_have, only_a, only_b}, success {both, only_a, only_b, neither,
// difference, low, high, mcnemar_p, verdict}, metrics [{name, pairs, only_a, only_b, differs,
// verdict, mean | median | quantile_95: {a, b, difference, low, high}}], verdict: "better" | "worse" | "not
// shown", sentence.
std::string ToJson(const Comparison& comparison);

}  // namespace kestrel::campaign
