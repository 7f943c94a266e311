// SPDX-License-Identifier: Apache-2.0
// What a campaign came to, as tables for the terminal.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "campaign/counted.h"
#include "campaign/statistics/campaign_summary.h"

namespace kestrel::campaign {
namespace {

constexpr std::size_t kMaxRows = 8;     // of a group of failures that are named
constexpr std::size_t kMaxEffects = 6;  // on one metric

std::string Shown(const Estimate& e) {
  const auto end = [](double x) { return std::isfinite(x) ? fmt::format("{:.3g}", x) : std::string("?"); };
  return fmt::format("{:.3g} [{}, {}]", e.value, end(e.interval.low), end(e.interval.high));
}

// An outcome may be as long as a message with all mistakes of a scenario.
std::string Short(const std::string& outcome) {
  constexpr std::size_t kMost = 60;
  const std::string line = outcome.substr(0, outcome.find('\n'));
  return line.size() == outcome.size() && line.size() <= kMost ? line : line.substr(0, kMost) + "...";
}

std::string Percent(double share) { return fmt::format("{:.2f} %", 100 * share); }

void AddMetrics(const CampaignSummary& s, std::string& text) {
  if (s.metrics.empty()) return;
  text += fmt::format("\n| {:<30} | {:>5} | {:>25} | {:>25} | {:>25} | {:>25} |\n", "metric [95 % interval]",
                      "runs", "mean", "5 % quantile", "median", "95 % quantile");
  text += fmt::format("|{:-<32}|{:->6}:|{:->26}:|{:->26}:|{:->26}:|{:->26}:|\n", "", "", "", "", "", "");
  const bool all = std::none_of(s.metrics.begin(), s.metrics.end(), [](const auto& m) { return m.listed; });
  for (const MetricSummary& m : s.metrics)
    if (m.listed || all)
      text += fmt::format("| {:<30} | {:>5} | {:>25} | {:>25} | {:>25} | {:>25} |\n", m.name, m.runs,
                          Shown(m.mean), Shown(m.quantiles.at(0.05)), Shown(m.quantiles.at(0.5)),
                          Shown(m.quantiles.at(0.95)));
}

void AddFailures(const CampaignSummary& s, std::string& text) {
  if (s.failures.empty()) return;
  text += fmt::format("\n| {:>5} | {:<10} | {:<40} | {:<40} |\n", "runs", "status", "outcome", "rows");
  text += fmt::format("|{:->6}:|{:-<12}|{:-<42}|{:-<42}|\n", "", "", "", "");
  for (const FailureGroup& f : s.failures) {
    std::string rows = fmt::format(
        "{}",
        fmt::join(f.rows.begin(),
                  f.rows.begin() + static_cast<std::ptrdiff_t>(std::min(f.rows.size(), kMaxRows)), ", "));
    if (f.rows.size() > kMaxRows) rows += ", ...";
    text += fmt::format("| {:>5} | {:<10} | {:<40} | {:<40} |\n", f.rows.size(), NameOf(f.status),
                        Short(f.outcome), rows);
  }
}

// How much a key matters, for the order of the lines.
double Size(const Effect& e) {
  const double rank = e.rank_correlation ? e.rank_correlation->value : 0;
  return std::max(rank * rank, e.first_order ? e.first_order->value : 0);
}

void AddEffects(const CampaignSummary& s, std::string& text) {
  std::string lines;
  const auto add = [&](const std::string& of) {
    std::vector<const Effect*> effects;
    for (const Effect& e : s.effects)
      if (e.of == of) effects.push_back(&e);
    std::stable_sort(effects.begin(), effects.end(),
                     [](const Effect* a, const Effect* b) { return Size(*a) > Size(*b); });
    effects.resize(std::min(effects.size(), kMaxEffects));
    for (const Effect* e : effects)
      lines += fmt::format("| {:<30} | {:<36} | {:>25} | {:>25} |\n", e->of, e->key,
                           e->rank_correlation ? Shown(*e->rank_correlation) : "",
                           e->first_order ? Shown(*e->first_order) : "");
  };
  add("success");
  for (const MetricSummary& m : s.metrics)
    if (m.listed) add(m.name);
  if (lines.empty()) return;
  text += fmt::format("\n| {:<30} | {:<36} | {:>25} | {:>25} |\n", "effect on [95 % interval]", "of",
                      "rank correlation", "share of variance alone");
  text += fmt::format("|{:-<32}|{:-<38}|{:->26}:|{:->26}:|\n", "", "", "", "");
  text += lines;
}

void AddWorst(const CampaignSummary& s, std::string& text) {
  for (const WorstRuns& w : s.worst) {
    text += fmt::format("\nWorst {}:\n", w.metric);
    for (const WorstRuns::Run& r : w.runs)
      text += fmt::format("  {:>10.4g}  {:<10} {:<24} {}\n", r.value, NameOf(r.status), Short(r.outcome),
                          r.command);
  }
}

void AddThresholds(const CampaignSummary& s, std::string& text) {
  if (s.thresholds.empty()) return;
  text += "\nThresholds, each held against the end of the 95 % interval that is against it:\n";
  for (const JudgedThreshold& t : s.thresholds) {
    text += fmt::format("  {:<4} {:<44} {:>10}   at {} {:g}", t.passed ? "ok" : "NOT", t.name,
                        std::isfinite(t.bound) ? fmt::format("{:.4g}", t.bound) : "none",
                        t.at_least ? "least" : "most", t.limit);
    if (t.runs_to_tell)
      text += fmt::format("   (too few runs to tell: {} would do that came out alike)", *t.runs_to_tell);
    text += t.without > 0
                ? fmt::format("   ({} of {} without it: worse than any)\n", t.without, Counted(t.runs, "run"))
                : "\n";
  }
}

}  // namespace

std::string ToText(const CampaignSummary& s) {
  std::string text = fmt::format("{}: {} of {}\n", s.name, s.runs, Counted(s.rows, "run"));
  if (s.runs == 0) return text;
  text += fmt::format("success {} ({} of {}), 95 % interval {} to {}", Percent(s.success.value), s.passed,
                      s.runs, Percent(s.success.interval.low), Percent(s.success.interval.high));
  text += s.stop_when ? " that holds however often one looks\n"
                      : fmt::format("; at least {} with 95 % confidence\n", Percent(s.success_at_least));
  if (s.ended_early)
    text += fmt::format(
        "ended early after {} of {} (--stop-when {:g}); intervals of metrics are those of a number of "
        "runs that was fixed\n",
        s.runs, Counted(s.rows, "run"), *s.stop_when);
  AddMetrics(s, text);
  AddFailures(s, text);
  AddEffects(s, text);
  AddWorst(s, text);
  AddThresholds(s, text);
  return text;
}

}  // namespace kestrel::campaign
