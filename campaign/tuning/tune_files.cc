// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace kestrel::campaign {
namespace {

using Json = nlohmann::ordered_json;

std::string PassedText(const Evaluation& e) {
  return fmt::format("{} of {} passed", std::count(e.passed.begin(), e.passed.end(), true), e.passed.size());
}

std::string DifferenceText(const PairedCost& d) {
  return fmt::format("{:+.4g} [{:+.4g}, {:+.4g}]", d.difference, d.low, d.high);
}

std::string JudgementOf(const PairedCost& d, const std::string& than) {
  return d.high < 0  ? fmt::format("better than {}", than)
         : d.low > 0 ? fmt::format("worse than {}", than)
                     : fmt::format("not shown to differ from {}", than);
}

std::string LimitText(const CostConstraint& c) {
  if (c.max && c.min) return fmt::format("{:g} to {:g}", *c.min, *c.max);
  return c.max ? fmt::format("at most {:g}", *c.max) : fmt::format("at least {:g}", *c.min);
}

Json ToJson(const Evaluation& e) {
  Json json = {{"round", e.round}, {"flights", e.flights}, {"gains", e.gains},
               {"cost", e.Cost()}, {"costs", e.costs},     {"passed", e.passed}};
  if (!e.kept.empty()) json["kept"] = e.kept;
  return json;
}

// Where better ones may lie beyond.
bool AtItsBound(const Gain& gain, double value) { return value == gain.low || value == gain.high; }

// Whether in no round of the search one candidate was any better than another.
bool NothingToGoBy(const TuneResult& result) {
  std::map<int, std::set<double>> costs;
  for (const Evaluation& e : result.search) costs[result.compares_rounds ? 0 : e.round].insert(e.Cost());
  return std::all_of(costs.begin(), costs.end(), [](const auto& round) { return round.second.size() == 1; });
}

Json ToJson(const PairedCost& d) { return {{"difference", d.difference}, {"low", d.low}, {"high", d.high}}; }

}  // namespace

std::vector<std::string> BrokenConstraints(const LoadedTune& tune, const TuneResult& result) {
  std::vector<std::string> broken;
  for (const auto& [metric, constraint] : tune.plan.cost.constraints) {
    const auto kept = [&metric = metric](const Evaluation& e) {
      const auto found = e.kept.find(metric);
      return found == e.kept.end() ? 0 : found->second;
    };
    const auto any = [&](const std::vector<Evaluation>& all) {
      return std::any_of(all.begin(), all.end(), [&](const Evaluation& e) { return kept(e) > 0; });
    };
    const std::string what = fmt::format("{} ({})", metric, LimitText(constraint));
    const auto rows = result.tuned.costs.size();
    if (!any(result.search) && !any(result.leaders) && kept(result.tuned) == 0)
      broken.push_back(fmt::format("No candidate met the constraint on {} in any flight.", what));
    else if (static_cast<std::size_t>(kept(result.tuned)) < rows)
      broken.push_back(fmt::format("The tuned gains met the constraint on {} in {} of {} flights.", what,
                                   kept(result.tuned), rows));
  }
  return broken;
}

std::string GainsFile(const LoadedTune& tune, const TuneResult& result, const std::string& command,
                      const std::string& version) {
  const TunePlan& plan = tune.plan;
  std::string text = fmt::format(
      "# Gains of {}, found by: {}\n"
      "# {}, seed {}, {} flights, by kestrel {}.\n"
      "# Cost on {} held-out rows (seed {}): {:.4g}, {}; of those it began with {:.4g}, {}:\n"
      "# the difference is {}, {}.\n",
      plan.flights.scenario, command, plan.method, plan.flights.seed, result.flights, version,
      result.tuned.costs.size(), plan.held_out_seed, result.tuned.Cost(), PassedText(result.tuned),
      result.start.Cost(), PassedText(result.start), DifferenceText(result.from_start),
      JudgementOf(result.from_start, "those"));
  if (result.own)
    text += fmt::format("# Of those that the scenario had {:.4g}, {}: the difference is {}, {}.\n",
                        result.own->Cost(), PassedText(*result.own), DifferenceText(*result.from_own),
                        JudgementOf(*result.from_own, "those"));
  for (const std::string& each : BrokenConstraints(tune, result)) text += fmt::format("# {}\n", each);
  for (const auto& [key, value] : result.gains)
    text += fmt::format("{}: {}  # began at {}{}\n", key, value, *plan.gains.at(key).start,
                        AtItsBound(plan.gains.at(key), value) ? "; a bound of where it was looked for" : "");
  for (const std::string& each : tune.others) {
    const std::size_t equals = each.find('=');
    text += fmt::format("{}: {}  # not tuned\n", each.substr(0, equals), each.substr(equals + 1));
  }
  return text;
}

std::string TuneJson(const LoadedTune& tune, const TuneResult& result, const std::string& version) {
  const TunePlan& plan = tune.plan;
  Json json = {{"name", plan.flights.name},
               {"scenario", plan.flights.scenario},
               {"version", version},
               {"method", plan.method},
               {"seed", plan.flights.seed},
               {"budget", plan.budget},
               {"flights", result.flights},
               {"gains", Json::object()},
               {"compares_rounds", result.compares_rounds},
               {"search", Json::array()},
               {"leaders", Json::array()}};
  for (const auto& [key, gain] : plan.gains) {
    Json& entry = json["gains"][key] = {
        {"low", gain.low}, {"high", gain.high}, {"log", gain.log}, {"start", *gain.start}};
    if (tune.own.contains(key)) entry["own"] = tune.own.at(key);
    entry["tuned"] = result.gains.at(key);
  }
  for (const Evaluation& e : result.search) json["search"].push_back(ToJson(e));
  for (const Evaluation& e : result.leaders) json["leaders"].push_back(ToJson(e));
  Json& held_out = json["held_out"] = {{"seed", plan.held_out_seed},
                                       {"start", ToJson(result.start)},
                                       {"tuned", ToJson(result.tuned)},
                                       {"from_start", ToJson(result.from_start)},
                                       {"better", result.Better()}};
  if (result.own) held_out["own"] = ToJson(*result.own), held_out["from_own"] = ToJson(*result.from_own);
  return json.dump(1) + '\n';
}

std::string TuneText(const LoadedTune& tune, const TuneResult& result) {
  std::string text = fmt::format("{:<44} {:>11} {:>11}\n", "gain", "start", "tuned");
  for (const auto& [key, value] : result.gains)
    text += fmt::format("{:<44} {:>11.5g} {:>11.5g}{}\n", key, *tune.plan.gains.at(key).start, value,
                        AtItsBound(tune.plan.gains.at(key), value) ? "   its bound" : "");
  text += fmt::format("\ncost on {} rows that the search never saw, after {} flights of it:\n",
                      result.tuned.costs.size(), result.flights);
  text += fmt::format("  start   {:10.4g}   {}\n", result.start.Cost(), PassedText(result.start));
  if (result.own)
    text += fmt::format("  before  {:10.4g}   {}\n", result.own->Cost(), PassedText(*result.own));
  text += fmt::format("  tuned   {:10.4g}   {}\n", result.tuned.Cost(), PassedText(result.tuned));
  return text + VerdictText(tune, result) + '\n';
}

std::string VerdictText(const LoadedTune& tune, const TuneResult& result) {
  std::string text =
      fmt::format("The tuned gains are {}: {} with 95 % confidence.",
                  JudgementOf(result.from_start, "those it began with"), DifferenceText(result.from_start));
  if (result.own)
    text += fmt::format(" They are {}: {}.", JudgementOf(*result.from_own, "those that the scenario had"),
                        DifferenceText(*result.from_own));
  for (const std::string& each : BrokenConstraints(tune, result)) text += ' ' + each;
  if (NothingToGoBy(result))
    text += " All candidates of the search cost the same: nothing in the cost depends on these gains.";
  return text;
}

}  // namespace kestrel::campaign
