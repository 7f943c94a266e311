// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/run_result.h"
#include "campaign/statistics/intervals.h"
#include "campaign/table/campaign_plan.h"

namespace kestrel::campaign {

// A threshold and what the runs say of it.
struct JudgedThreshold {
  std::string name;  // "success", "touchdown_error_m, mean", "touchdown_error_m, 95 % quantile"
  Estimate estimate;
  double bound = 0;  // of the 95 % interval, the one that is against it
  double limit = 0;
  bool at_least = false;               // otherwise at most
  bool passed = false;                 // the bound keeps to the limit
  std::int64_t runs = 0, without = 0;  // all; of them, those that do not have the metric
  bool sequential = false;             // the interval is that of ShareSequence
  // Where the runs keep to the limit and are too few to tell: how many would do that came out alike.
  std::optional<std::int64_t> runs_to_tell = std::nullopt;
};

// In the order of their names; one with a maximum and a minimum is two. A run without the metric never
// did what it measures: it counts as worse than any that did, so that a mean is unbounded with one such run.
// Where none is on success, at least one run must have passed; `success: {min: 0}` asks for nothing.
// sequential: the number of runs was chosen by what they came to (StopRuleOf), so success is judged by an
// interval that holds then too.
std::vector<JudgedThreshold> Judge(const std::map<std::string, Threshold>& thresholds,
                                   const std::vector<RunResult>& results, bool sequential = false);

// JUnit XML of them, a case each, for CI servers.
std::string ToJunit(const std::string& campaign, const std::vector<JudgedThreshold>& thresholds);

}  // namespace kestrel::campaign
