// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/thresholds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "campaign/counted.h"
#include "campaign/statistics/share_sequence.h"
#include "records/junit.h"

namespace kestrel::campaign {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::int64_t PassedIn(const std::vector<RunResult>& results) {
  return std::count_if(results.begin(), results.end(),
                       [](const RunResult& result) { return result.status == RunStatus::kPassed; });
}

Interval IntervalOf(std::int64_t passed, std::int64_t runs, bool sequential) {
  return sequential ? ShareSequence(passed, runs) : ShareInterval(passed, runs);
}

Estimate SuccessOf(const std::vector<RunResult>& results, bool sequential) {
  const std::int64_t passed = PassedIn(results), runs = std::ssize(results);
  return {static_cast<double>(passed) / static_cast<double>(runs), IntervalOf(passed, runs, sequential)};
}

// The least number of runs for which it holds, of those above one for which it does not; none below kMaxRuns.
template <class Holds>
std::optional<std::int64_t> Least(std::int64_t above, const Holds& holds) {
  constexpr std::int64_t kMaxRuns = 10'000'000;
  std::int64_t low = std::max<std::int64_t>(above, 1), high = low;
  while (!holds(high)) {
    if (high >= kMaxRuns) return std::nullopt;
    low = high, high *= 2;
  }
  while (high - low > 1) {
    const std::int64_t middle = low + (high - low) / 2;
    (holds(middle) ? high : low) = middle;
  }
  return high;
}

// Of a share of successes like this one.
std::optional<std::int64_t> RunsToTellShare(std::int64_t passed, std::int64_t runs, double limit,
                                            bool at_least, bool sequential) {
  if (runs == 0) return std::nullopt;
  const double share = static_cast<double>(passed) / static_cast<double>(runs);
  if (at_least ? share <= limit : share >= limit) return std::nullopt;
  return Least(runs, [&](std::int64_t n) {
    // Rounded to the side that is against it.
    const double exact = share * static_cast<double>(n);
    const auto k = static_cast<std::int64_t>(at_least ? std::floor(exact + 1e-6) : std::ceil(exact - 1e-6));
    const Interval interval = IntervalOf(k, n, sequential);
    return at_least ? interval.low >= limit : interval.high <= limit;
  });
}

// Until a quantile has an end of its interval at all: until all samples are on one side of it by chance alone
// in one of 40 cases.
std::optional<std::int64_t> RunsToTellQuantile(std::int64_t runs, double quantile, bool at_least) {
  const double beyond = at_least ? 1 - quantile : quantile;
  return Least(runs, [&](std::int64_t n) { return std::pow(beyond, n) <= 0.025; });
}

// What is asked of a campaign that asks nothing of its success: without it, one that only failed would end as
// one that only passed.
JudgedThreshold SomeRunPassed(const std::vector<RunResult>& results) {
  const auto passed = static_cast<double>(PassedIn(results));
  return {.name = "runs that passed",
          .estimate = {passed, {passed, passed}},
          .bound = passed,
          .limit = 1,
          .at_least = true,
          .passed = passed >= 1,
          .runs = std::ssize(results)};
}

}  // namespace

std::vector<JudgedThreshold> Judge(const std::map<std::string, Threshold>& thresholds,
                                   const std::vector<RunResult>& results, bool sequential) {
  std::vector<JudgedThreshold> judged;
  for (const auto& [metric, threshold] : thresholds) {
    const auto judge = [&, &metric = metric, &threshold = threshold](double limit, bool at_least) {
      JudgedThreshold j;
      j.name = metric == "success"  ? metric
               : threshold.quantile ? fmt::format("{}, {:g} % quantile", metric, 100 * *threshold.quantile)
                                    : fmt::format("{}, mean", metric);
      j.limit = limit, j.at_least = at_least;
      j.runs = std::ssize(results);
      if (metric == "success") {
        j.sequential = sequential;
        j.estimate = SuccessOf(results, sequential);
      } else {
        std::vector<double> values;
        for (const RunResult& result : results) {
          const auto found = result.metrics.find(metric);
          const bool there = found != result.metrics.end() && !std::isnan(found->second);
          values.push_back(there ? found->second : at_least ? -kInfinity : kInfinity);
          j.without += !there;
        }
        j.estimate = threshold.quantile ? QuantileOf(values, *threshold.quantile) : MeanOf(values);
      }
      j.bound = at_least ? j.estimate.interval.low : j.estimate.interval.high;
      j.passed = at_least ? j.bound >= limit : j.bound <= limit;
      if (!j.passed && metric == "success")
        j.runs_to_tell = RunsToTellShare(PassedIn(results), j.runs, limit, at_least, sequential);
      else if (!j.passed && threshold.quantile && std::isinf(j.bound) && std::isfinite(j.estimate.value) &&
               (at_least ? j.estimate.value >= limit : j.estimate.value <= limit) && j.without == 0)
        j.runs_to_tell = RunsToTellQuantile(j.runs, *threshold.quantile, at_least);
      judged.push_back(std::move(j));
    };
    if (threshold.max) judge(*threshold.max, false);
    if (threshold.min) judge(*threshold.min, true);
  }
  if (!thresholds.contains("success")) judged.push_back(SomeRunPassed(results));
  return judged;
}

std::string ToJunit(const std::string& campaign, const std::vector<JudgedThreshold>& thresholds) {
  std::vector<records::JunitCase> cases;
  for (const JudgedThreshold& t : thresholds) {
    records::JunitCase& test = cases.emplace_back(records::JunitCase{campaign, campaign, t.name, 0, {}, {}});
    if (t.passed) continue;
    const char* end = t.at_least ? "lower" : "upper";
    const auto shown = [](double x) {
      return std::isfinite(x) ? fmt::format("{:.4g}", x) : std::string("nowhere known");
    };
    test.failure = fmt::format("{}: ", t.name);
    if (std::isfinite(t.estimate.value))
      test.failure +=
          fmt::format("{:.4g}, 95 % interval from {} to {}{}, over {}; ", t.estimate.value,
                      shown(t.estimate.interval.low), shown(t.estimate.interval.high),
                      t.sequential ? ", which holds however often one looks" : "", Counted(t.runs, "run"));
    else
      test.failure += fmt::format("not known, over {}; ", Counted(t.runs, "run"));
    test.failure += fmt::format("its {} end must be at {} {:g}", end, t.at_least ? "least" : "most", t.limit);
    if (t.runs_to_tell)
      test.failure += fmt::format("; too few runs to tell: {} would do that came out alike", *t.runs_to_tell);
    if (t.without > 0)
      test.failure += fmt::format("; {} without it count{} as worse", Counted(t.without, "run"),
                                  t.without == 1 ? "s" : "");
  }
  return records::JunitXml(cases);
}

}  // namespace kestrel::campaign
