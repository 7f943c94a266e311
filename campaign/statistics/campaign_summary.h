// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"
#include "campaign/statistics/effects.h"
#include "campaign/statistics/intervals.h"
#include "campaign/statistics/metric_aims.h"
#include "campaign/statistics/thresholds.h"

namespace kestrel::campaign {

// What a metric came to, over the runs that have it as a finite number. Intervals are of 95 %.
struct MetricSummary {
  std::string name;
  std::int64_t runs = 0;
  bool listed = false;  // among those that the campaign's file, or the criteria, name
  std::optional<Better> better;
  double min = 0, max = 0;
  Estimate mean;
  std::map<double, Estimate> quantiles;  // 0.05, 0.5, 0.95
};

// Runs that did not pass and ended alike.
struct FailureGroup {
  RunStatus status = RunStatus::kFailed;
  std::string outcome;
  std::vector<std::int64_t> rows;
};

// The runs farthest on the wrong side of a metric, worst first.
struct WorstRuns {
  struct Run {
    std::int64_t row = 0;
    double value = 0;
    RunStatus status = RunStatus::kFailed;
    std::string outcome, command;
  };
  std::string metric;
  std::vector<Run> runs;
};

// Everything that a report shows of a campaign.
struct CampaignSummary {
  std::string name, version, table_hash;
  std::int64_t rows = 0, runs = 0, passed = 0;  // of the table; with a result; of those
  Estimate success;                 // share of the runs, 95 % interval: exact, or with a rule ShareSequence's
  double success_at_least = 0;      // one-sided 95 % bound; with a rule the lower end of that interval
  std::optional<double> stop_when;  // StopRuleOf
  bool ended_early = false;         // it was satisfied before the end of the table
  std::vector<MetricSummary> metrics;  // the listed ones first, in their order; then by name
  std::vector<FailureGroup> failures;  // the largest first
  std::vector<Effect> effects;         // on success and every metric
  std::vector<WorstRuns> worst;        // of the listed metrics of which it is known what is worse
  std::vector<JudgedThreshold> thresholds;
};

// results: in the order of their rows; with a rule for the end (StopRuleOf) those beyond the first row that
// has none do not count, as which of them there are depends on what they came to. replay: the command line
// that flies a row again, but for the row's number at its end; empty: that of the campaign by its name.
// thresholds: none for flights that are not to be judged, as those of a tuning.
CampaignSummary Summarise(const CampaignIdentity& identity, const std::vector<RunResult>& results,
                          const std::optional<std::map<std::string, Threshold>>& thresholds = {},
                          std::string replay = {});

// Tables for the terminal.
std::string ToText(const CampaignSummary& summary);

// JSON, for the report in HTML and other tools. "E" is an estimate, {"value", "low", "high"}: an end that is
// not known is null.
//   name, version, table_hash, rows, runs, passed
//   success      E, and "at_least": the one-sided bound
//   stop_when    of --stop-when: the interval of success holds however often one looks; null: it is exact
//   ended_early  whether the campaign ended by that before the end of its table
//   metrics      [{name, runs, listed, better: "lower" | "higher" | null, min, max, mean: E,
//                  quantiles: [{q, value, low, high}]}]
//   failures     [{status, outcome, rows: [...]}]
//   effects      [{key, of, runs, numeric, rank_correlation: E | null, first_order: E | null}]
//   worst        [{metric, runs: [{row, value, status, outcome, command}]}]
//   thresholds   [{name, value, low, high, bound, limit, at_least, passed, runs, without}]
std::string ToJson(const CampaignSummary& summary);

}  // namespace kestrel::campaign
