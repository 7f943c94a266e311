// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/diagnostics.h"

namespace kestrel::campaign {
namespace {

void RefuseOtherTable(const SampleTable& a, const SampleTable& b) {
  Mistakes mistakes;
  const auto lacks = [&](const SampleTable& from, const SampleTable& other, const char* with,
                         const char* without) {
    for (const std::string& key : from.keys)
      if (std::find(other.keys.begin(), other.keys.end(), key) == other.keys.end())
        mistakes.Add("compare", key, fmt::format("varies in {} and not in {}", with, without));
  };
  lacks(a, b, "A", "B"), lacks(b, a, "B", "A");
  if (a.rows.size() != b.rows.size())
    mistakes.Add("compare", "", fmt::format("A has {} rows and B {}", a.rows.size(), b.rows.size()));
  if (mistakes.empty()) {
    std::size_t other = 0;
    std::string first;
    for (std::size_t row = 0; row < a.rows.size(); ++row) {
      bool same = true;
      for (std::size_t k = 0; k < a.keys.size(); ++k) {
        const auto at =
            static_cast<std::size_t>(std::find(b.keys.begin(), b.keys.end(), a.keys[k]) - b.keys.begin());
        if (a.rows[row][k] == b.rows[row][at]) continue;
        if (first.empty())
          first = fmt::format("row {} has {} = {} in A and {} in B", row, a.keys[k], a.rows[row][k],
                              b.rows[row][at]);
        same = false;
      }
      other += !same;
    }
    if (other > 0) mistakes.Add("compare", "", fmt::format("{} ({} rows differ)", first, other));
  }
  if (!mistakes.empty())
    mistakes.Add("compare", "", "the two are not of the same rows",
                 "valid: campaigns of one seed, sampling and `vary`");
  mistakes.ThrowIfAny();
}

std::vector<std::string> SettingsThatDiffer(const CampaignIdentity& a, const CampaignIdentity& b) {
  std::vector<std::string> differs;
  const auto in_a = ValuesOf(a.scenario, "A"), in_b = ValuesOf(b.scenario, "B");
  const auto value = [](const std::map<std::string, std::string>& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? "none" : found->second;
  };
  std::map<std::string, std::string> keys = in_a;
  keys.insert(in_b.begin(), in_b.end());
  for (const auto& [key, unused] : keys)
    if (key != "name" && value(in_a, key) != value(in_b, key))
      differs.push_back(fmt::format("{}: {} in A, {} in B", key, value(in_a, key), value(in_b, key)));
  for (const std::string& model : ModelsThatDiffer(a.models, b.models))
    differs.push_back(fmt::format("models/{}: another in A than in B", model));
  if (a.version != b.version)
    differs.push_back(fmt::format("version: {} in A, {} in B", a.version, b.version));
  if (a.machine.empty() != b.machine.empty())
    differs.push_back(fmt::format("machine: that of {} is not known", a.machine.empty() ? "A" : "B"));
  else
    for (const auto& [name, values] : sim::MachineDifferences(a.machine, b.machine))
      differs.push_back(fmt::format("machine/{}: {} in A, {} in B", name, values.first, values.second));
  return differs;
}

std::vector<std::string> Once(const std::vector<std::string>& names) {
  std::vector<std::string> once;
  for (const std::string& name : names)
    if (std::find(once.begin(), once.end(), name) == once.end()) once.push_back(name);
  return once;
}

std::vector<std::string> MetricsToCompare(const MetricAims& a, const MetricAims& b) {
  std::vector<std::string> metrics = a.listed;
  metrics.insert(metrics.end(), b.listed.begin(), b.listed.end());
  return metrics;
}

std::optional<double> MetricOf(const RunResult& result, const std::string& name) {
  const auto found = result.metrics.find(name);
  if (found == result.metrics.end() || !std::isfinite(found->second)) return std::nullopt;
  return found->second;
}

bool Differs(const MetricComparison& m) { return !m.differences.mean_stricter.Holds(0); }

Verdict VerdictOf(const Interval& difference, std::optional<Better> better) {
  if (!better || difference.Holds(0)) return Verdict::kNotShown;
  return (difference.low > 0) == (*better == Better::kHigher) ? Verdict::kBetter : Verdict::kWorse;
}

std::string_view NameOf(Verdict verdict) {
  return verdict == Verdict::kBetter ? "better" : verdict == Verdict::kWorse ? "worse" : "not shown";
}

template <class Which>
std::string NamesOf(const Comparison& c, const Which& which) {
  std::string names;
  for (const MetricComparison& m : c.metrics)
    if (which(m))
      names += fmt::format("{}{} ({:.3g} against {:.3g} in the mean)", names.empty() ? "" : ", ", m.name,
                           m.differences.mean.b, m.differences.mean.a);
  return names;
}

void Conclude(Comparison& c) {
  const auto with = [](Verdict verdict) { return [=](const auto& m) { return m.verdict == verdict; }; };
  const std::string better = NamesOf(c, with(Verdict::kBetter)), worse = NamesOf(c, with(Verdict::kWorse));
  const std::string unjudged = NamesOf(c, [](const auto& m) { return !m.better && Differs(m); });
  const double rows = static_cast<double>(c.ends.rows());
  std::string success = fmt::format(
      "{:.1f} % against {:.1f} % of {} rows pass ({:+.1f} points, 95 % interval {:+.1f} to "
      "{:+.1f}, McNemar p = {:.2g})",
      100 * static_cast<double>(c.ends.both + c.ends.only_b) / rows,
      100 * static_cast<double>(c.ends.both + c.ends.only_a) / rows, c.ends.rows(), 100 * c.success.value,
      100 * c.success.interval.low, 100 * c.success.interval.high, c.chance);
  const bool near = c.success_verdict == Verdict::kNotShown && !c.success.interval.Holds(0);
  if (near) success += ", which is exact and decides: the interval is an approximation";
  if (c.success_verdict != Verdict::kNotShown) {
    c.verdict = c.success_verdict;
    c.sentence = fmt::format("B is {} than A: {}", NameOf(c.verdict), success);
    if (!better.empty()) c.sentence += "; better in " + better;
    if (!worse.empty()) c.sentence += "; worse in " + worse;
  } else if (better.empty() != worse.empty()) {
    c.verdict = worse.empty() ? Verdict::kBetter : Verdict::kWorse;
    c.sentence = fmt::format("B is {} than A in {}; of success no difference is shown: {}", NameOf(c.verdict),
                             better + worse, success);
  } else if (!better.empty()) {
    c.sentence = fmt::format("Not shown that B is better or worse than A: better in {}, worse in {}; {}",
                             better, worse, success);
  } else {
    c.sentence = fmt::format(
        "Not shown that B is better or worse than A: {}{}", success,
        c.metrics.empty() || !unjudged.empty() ? "" : ", and no metric differs by more than chance may");
  }
  if (!unjudged.empty())
    c.sentence +=
        fmt::format("; other in {}, which no criterion or threshold calls better or worse", unjudged);
  c.sentence += '.';
}

}  // namespace

Comparison Compare(const CampaignResults& a, const CampaignResults& b, std::vector<std::string> metrics,
                   std::uint64_t seed, int resamples) {
  RefuseOtherTable(a.identity.table, b.identity.table);
  Comparison c;
  c.differs = SettingsThatDiffer(a.identity, b.identity);
  std::map<std::int64_t, const RunResult*> in_b;
  for (const RunResult& result : b.results) in_b[result.row] = &result;
  std::vector<std::pair<const RunResult*, const RunResult*>> pairs;
  for (const RunResult& result : a.results) {
    const auto found = in_b.find(result.row);
    if (found == in_b.end())
      ++c.rows_only_a;
    else
      pairs.emplace_back(&result, found->second);
  }
  c.rows_only_b = std::ssize(b.results) - std::ssize(pairs);
  if (pairs.empty()) throw InputError({}, "compare: there is no row of which both have a result");

  for (const auto& [of_a, of_b] : pairs) {
    const bool passed_a = of_a->status == RunStatus::kPassed, passed_b = of_b->status == RunStatus::kPassed;
    ++(passed_a ? passed_b ? c.ends.both : c.ends.only_a : passed_b ? c.ends.only_b : c.ends.neither);
  }
  c.success = ShareDifference(c.ends);
  c.chance = McNemar(c.ends);
  if (c.chance < 0.05) c.success_verdict = c.success.value > 0 ? Verdict::kBetter : Verdict::kWorse;

  const MetricAims aims_a = AimsOf(a.identity), aims_b = AimsOf(b.identity);
  const bool asked = !metrics.empty();
  if (!asked) metrics = MetricsToCompare(aims_a, aims_b);
  metrics = Once(metrics);
  std::map<std::string, Better> better = aims_a.better;
  better.insert(aims_b.better.begin(), aims_b.better.end());
  const auto judged = std::count_if(metrics.begin(), metrics.end(),
                                    [&](const std::string& name) { return better.contains(name); });
  // The differences of all metrics of a kind together are by chance with a probability of 5 % at most.
  const auto level = [](std::ptrdiff_t of) {
    return 1 - 0.05 / static_cast<double>(std::max<std::ptrdiff_t>(1, of));
  };
  const double level_judged = level(judged), level_others = level(std::ssize(metrics) - judged);
  Mistakes mistakes;
  for (const std::string& name : metrics) {
    MetricComparison m;
    m.name = name;
    if (const auto found = better.find(name); found != better.end()) m.better = found->second;
    std::vector<double> values_a, values_b;
    for (const auto& [of_a, of_b] : pairs) {
      const auto value_a = MetricOf(*of_a, name), value_b = MetricOf(*of_b, name);
      m.only_a += value_a && !value_b, m.only_b += value_b && !value_a;
      if (value_a && value_b) values_a.push_back(*value_a), values_b.push_back(*value_b);
    }
    m.pairs = std::ssize(values_a);
    if (m.pairs < 2) {
      if (asked)
        mistakes.Add(
            "--metric", name,
            m.pairs + m.only_a + m.only_b == 0 ? "no row has it" : "fewer than two rows have it in both");
      continue;
    }
    m.differences =
        DifferencesOf(values_a, values_b, seed, m.better ? level_judged : level_others, resamples);
    m.verdict = VerdictOf(m.differences.mean_stricter, m.better);
    c.metrics.push_back(std::move(m));
  }
  mistakes.ThrowIfAny();
  Conclude(c);
  return c;
}

std::string ToText(const Comparison& c) {
  std::string text;
  for (const std::string& line : c.differs) text += fmt::format("  {}\n", line);
  if (c.differs.empty()) text += "  the two are of the same settings and version\n";
  if (c.rows_only_a + c.rows_only_b > 0)
    text += fmt::format("  left out: {} rows of which A alone has a result, {} of which B alone\n",
                        c.rows_only_a, c.rows_only_b);
  text += fmt::format("\nrows passed by both {}, by A alone {}, by B alone {}, by neither {}\n", c.ends.both,
                      c.ends.only_a, c.ends.only_b, c.ends.neither);
  if (!c.metrics.empty()) {
    text += fmt::format("\n| {:<30} | {:>5} | {:<13} | {:>9} | {:>9} | {:>10} | {:<23} | {:<9} |\n", "metric",
                        "rows", "of it", "A", "B", "B - A", "95 % interval", "B is");
    text += fmt::format("|{:-<32}|{:->6}:|{:-<15}|{:->10}:|{:->10}:|{:->11}:|{:-<25}|{:-<11}|\n", "", "", "",
                        "", "", "", "", "");
    for (const MetricComparison& m : c.metrics) {
      const auto line = [&](const char* name, const PairedDifference& d, bool first) {
        text +=
            fmt::format("| {:<30} | {:>5} | {:<13} | {:>9.4g} | {:>9.4g} | {:>+10.3g} | {:<23} | {:<9} |\n",
                        first ? m.name : "", first ? fmt::format("{}", m.pairs) : "", name, d.a, d.b,
                        d.b - d.a, fmt::format("{:+.3g} to {:+.3g}", d.interval.low, d.interval.high),
                        !first     ? ""
                        : m.better ? NameOf(m.verdict)
                                   : "");
      };
      line("mean", m.differences.mean, true);
      line("median", m.differences.median, false);
      line("95 % quantile", m.differences.quantile_95, false);
      if (m.only_a + m.only_b > 0)
        text += fmt::format("| {:<30} | {:>5} rows have it in A alone, {} in B alone: not compared\n", "",
                            m.only_a, m.only_b);
    }
  }
  return text + '\n' + c.sentence + '\n';
}

std::string ToJson(const Comparison& c) {
  using Json = nlohmann::ordered_json;
  Json json = {{"differs", c.differs},
               {"rows", {{"both_have", c.ends.rows()}, {"only_a", c.rows_only_a}, {"only_b", c.rows_only_b}}},
               {"success",
                {{"both", c.ends.both},
                 {"only_a", c.ends.only_a},
                 {"only_b", c.ends.only_b},
                 {"neither", c.ends.neither},
                 {"difference", c.success.value},
                 {"low", c.success.interval.low},
                 {"high", c.success.interval.high},
                 {"mcnemar_p", c.chance},
                 {"verdict", NameOf(c.success_verdict)}}},
               {"metrics", Json::array()}};
  for (const MetricComparison& m : c.metrics) {
    const auto difference = [](const PairedDifference& d) {
      return Json{{"a", d.a},
                  {"b", d.b},
                  {"difference", d.b - d.a},
                  {"low", d.interval.low},
                  {"high", d.interval.high}};
    };
    json["metrics"].push_back({{"name", m.name},
                               {"pairs", m.pairs},
                               {"only_a", m.only_a},
                               {"only_b", m.only_b},
                               {"differs", Differs(m)},
                               {"verdict", NameOf(m.verdict)},
                               {"mean", difference(m.differences.mean)},
                               {"median", difference(m.differences.median)},
                               {"quantile_95", difference(m.differences.quantile_95)}});
  }
  json["verdict"] = NameOf(c.verdict);
  json["sentence"] = c.sentence;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace kestrel::campaign
