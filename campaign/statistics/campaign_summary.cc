// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/campaign_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "campaign/statistics/share_sequence.h"
#include "campaign/statistics/stop_rule.h"

namespace kestrel::campaign {
namespace {

constexpr std::size_t kWorst = 5;  // runs of a metric

std::vector<std::pair<double, const RunResult*>> Having(const std::vector<RunResult>& results,
                                                        const std::string& metric) {
  std::vector<std::pair<double, const RunResult*>> having;
  for (const RunResult& result : results) {
    const auto found = result.metrics.find(metric);
    if (found != result.metrics.end() && std::isfinite(found->second))
      having.emplace_back(found->second, &result);
  }
  return having;
}

std::vector<std::string> MetricsOf(const std::vector<RunResult>& results,
                                   const std::vector<std::string>& listed) {
  std::set<std::string> there;
  for (const RunResult& result : results)
    for (const auto& [name, value] : result.metrics)
      if (std::isfinite(value)) there.insert(name);
  std::vector<std::string> names;
  for (const std::string& name : listed)
    if (there.erase(name)) names.push_back(name);
  names.insert(names.end(), there.begin(), there.end());
  return names;
}

MetricSummary SummaryOf(const std::string& name, const std::vector<double>& values) {
  MetricSummary metric;
  metric.name = name;
  metric.runs = std::ssize(values);
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  metric.min = *min, metric.max = *max;
  metric.mean = MeanOf(values);
  for (const double q : {0.05, 0.5, 0.95}) metric.quantiles[q] = QuantileOf(values, q);
  return metric;
}

std::vector<FailureGroup> FailuresOf(const std::vector<RunResult>& results) {
  std::map<std::pair<RunStatus, std::string>, std::vector<std::int64_t>> groups;
  for (const RunResult& result : results)
    if (result.status != RunStatus::kPassed) groups[{result.status, result.outcome}].push_back(result.row);
  std::vector<FailureGroup> failures;
  for (auto& [end, rows] : groups) failures.push_back({end.first, end.second, std::move(rows)});
  std::stable_sort(failures.begin(), failures.end(), [](const FailureGroup& a, const FailureGroup& b) {
    return a.rows.size() > b.rows.size();
  });
  return failures;
}

WorstRuns WorstOf(const std::string& metric, Better better, const std::vector<RunResult>& results,
                  const std::string& replay) {
  auto having = Having(results, metric);
  std::stable_sort(having.begin(), having.end(), [&](const auto& a, const auto& b) {
    return better == Better::kLower ? a.first > b.first : a.first < b.first;
  });
  having.resize(std::min(having.size(), kWorst));
  WorstRuns worst{metric, {}};
  for (const auto& [value, run] : having)
    worst.runs.push_back(
        {run->row, value, run->status, run->outcome, fmt::format("{} {}", replay, run->row)});
  return worst;
}

// Those before the first row that has none.
std::vector<RunResult> WithoutGaps(const std::vector<RunResult>& results) {
  std::ptrdiff_t n = 0;
  while (n < std::ssize(results) && results[static_cast<std::size_t>(n)].row == n) ++n;
  return {results.begin(), results.begin() + n};
}

}  // namespace

CampaignSummary Summarise(const CampaignIdentity& identity, const std::vector<RunResult>& all,
                          const std::optional<std::map<std::string, Threshold>>& thresholds,
                          std::string replay) {
  const std::optional<double> stop_when = StopRuleOf(identity);
  const std::vector<RunResult> results = stop_when ? WithoutGaps(all) : all;
  if (replay.empty()) replay = "kestrel campaign replay " + identity.name;
  CampaignSummary s;
  s.name = identity.name, s.version = identity.version, s.table_hash = HashOf(identity.table);
  s.rows = std::ssize(identity.table.rows), s.runs = std::ssize(results);
  s.passed = std::count_if(results.begin(), results.end(),
                           [](const RunResult& r) { return r.status == RunStatus::kPassed; });
  if (s.runs > 0) s.success.value = static_cast<double>(s.passed) / static_cast<double>(s.runs);
  s.stop_when = stop_when;
  s.success.interval = s.stop_when ? ShareSequence(s.passed, s.runs) : ShareInterval(s.passed, s.runs);
  s.success_at_least = s.stop_when ? s.success.interval.low : ShareAtLeast(s.passed, s.runs);
  s.ended_early = s.stop_when && s.runs < s.rows && NarrowEnough(s.passed, s.runs, *s.stop_when);

  const MetricAims aims = AimsOf(identity);
  std::vector<std::string> effects_of = {"success"};
  for (const std::string& name : MetricsOf(results, aims.listed)) {
    effects_of.push_back(name);
    std::vector<double> values;
    for (const auto& [value, run] : Having(results, name)) values.push_back(value);
    MetricSummary& metric = s.metrics.emplace_back(SummaryOf(name, values));
    metric.listed = std::count(aims.listed.begin(), aims.listed.end(), name) > 0;
    const auto better = aims.better.find(name);
    if (better == aims.better.end()) continue;
    metric.better = better->second;
    if (metric.listed) s.worst.push_back(WorstOf(name, better->second, results, replay));
  }
  s.failures = FailuresOf(results);
  s.effects = EffectsOf(identity.table, results, effects_of);
  if (thresholds) s.thresholds = Judge(*thresholds, results, s.stop_when.has_value());
  return s;
}

std::string ToJson(const CampaignSummary& s) {
  using Json = nlohmann::ordered_json;  // its dump writes numbers that are not finite as null
  const auto add = [](Json& json, const Estimate& e) {
    json["value"] = e.value, json["low"] = e.interval.low, json["high"] = e.interval.high;
  };
  const auto estimate = [&](const std::optional<Estimate>& e) {
    Json json;
    if (e) add(json, *e);
    return json;
  };
  Json json = {{"name", s.name}, {"version", s.version}, {"table_hash", s.table_hash},    {"rows", s.rows},
               {"runs", s.runs}, {"passed", s.passed},   {"success", estimate(s.success)}};
  json["success"]["at_least"] = s.success_at_least;
  json["stop_when"] = s.stop_when ? Json(*s.stop_when) : Json();
  json["ended_early"] = s.ended_early;
  for (const char* list : {"metrics", "failures", "effects", "worst", "thresholds"})
    json[list] = Json::array();
  for (const MetricSummary& m : s.metrics) {
    Json quantiles = Json::array();
    for (const auto& [q, e] : m.quantiles) add(quantiles.emplace_back(Json{{"q", q}}), e);
    json["metrics"].push_back(
        {{"name", m.name},
         {"runs", m.runs},
         {"listed", m.listed},
         {"better", m.better ? Json(*m.better == Better::kLower ? "lower" : "higher") : Json()},
         {"min", m.min},
         {"max", m.max},
         {"mean", estimate(m.mean)},
         {"quantiles", quantiles}});
  }
  for (const FailureGroup& f : s.failures)
    json["failures"].push_back({{"status", NameOf(f.status)}, {"outcome", f.outcome}, {"rows", f.rows}});
  for (const Effect& e : s.effects)
    json["effects"].push_back({{"key", e.key},
                               {"of", e.of},
                               {"runs", e.runs},
                               {"numeric", e.numeric},
                               {"rank_correlation", estimate(e.rank_correlation)},
                               {"first_order", estimate(e.first_order)}});
  for (const WorstRuns& w : s.worst) {
    Json runs = Json::array();
    for (const WorstRuns::Run& r : w.runs)
      runs.push_back({{"row", r.row},
                      {"value", r.value},
                      {"status", NameOf(r.status)},
                      {"outcome", r.outcome},
                      {"command", r.command}});
    json["worst"].push_back({{"metric", w.metric}, {"runs", runs}});
  }
  for (const JudgedThreshold& t : s.thresholds) {
    Json threshold = {{"name", t.name}};
    add(threshold, t.estimate);
    threshold.update({{"bound", t.bound},
                      {"limit", t.limit},
                      {"at_least", t.at_least},
                      {"passed", t.passed},
                      {"runs", t.runs},
                      {"without", t.without}});
    if (t.runs_to_tell) threshold["runs_to_tell"] = *t.runs_to_tell;
    json["thresholds"].push_back(threshold);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace kestrel::campaign
