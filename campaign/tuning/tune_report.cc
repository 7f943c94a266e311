// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "base/process/shell_word.h"
#include "base/statistics.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/tuning/flight_cache.h"
#include "campaign/tuning/tune_files.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {
namespace {

std::string MethodText(const std::string& method) {
  return method == "cma_es" ? "CMA-ES" : method == "cross_entropy" ? "cross-entropy" : "random search";
}

std::string CostText(const FlightCost& cost) {
  std::vector<std::string> terms;
  for (const auto& [metric, term] : cost.terms)
    terms.push_back(fmt::format("{}{} / {}", term.weight == 1 ? "" : fmt::format("{} ", term.weight),
                                term.wanted ? fmt::format("({} - {})", *term.wanted, metric) : metric,
                                term.scale));
  const std::string penalties = cost.constraints.empty() ? "" : ", and penalties";
  return fmt::format("{}{}", fmt::join(terms, " + "), penalties);
}

SearchCurve CurveOf(const Searched& searched, int repetition) {
  SearchCurve curve{MethodText(searched.tune.plan.method), repetition, {}, {}, searched.result.tuned.Cost()};
  for (const SearchStage& stage : Stages(searched.result)) {
    curve.flights.push_back(static_cast<double>(stage.flights));
    curve.cost.push_back(stage.cost);
  }
  return curve;
}

}  // namespace

ReportSubject TuneSubject(const std::vector<Searched>& searches, const std::filesystem::path& folder,
                          const std::string& again) {
  const auto& [tune, result, runs] = searches.front();
  const CampaignPlan& flights = tune.plan.flights;
  ReportSubject subject;
  std::vector<std::string> set = flights.set;
  subject.run = "./kestrel run " + ShellWord(flights.scenario);
  for (const std::string& each : set) subject.run += " --set " + ShellWord(each);
  subject.run += " --set " + ShellWord("gains=" + (folder / "gains.yaml").string());
  for (const auto& [key, value] : result.gains) set.push_back(fmt::format("{}={}", key, value));
  subject.identity = {flights.name, ToYaml(flight::LoadScenario(flights.scenario, set).scenario), tune.text,
                      Version(), tune.held_out};
  subject.results = runs;
  subject.summary = Summarise(subject.identity, runs);
  subject.results_file = FlightsFile(folder).string();
  subject.again = again;

  TuningHistory& history = subject.tuning.emplace();
  history.cost = CostText(tune.plan.cost);
  history.start_cost = result.start.Cost();
  history.verdict = VerdictText(tune, result);
  std::map<std::string, int> repetitions;
  for (const Searched& each : searches)
    history.searches.push_back(CurveOf(each, ++repetitions[each.tune.plan.method]));
  for (const auto& [key, gain] : tune.plan.gains)
    history.gains.push_back({key, *gain.start, result.gains.at(key), gain.low, gain.high, gain.log});
  return subject;
}

std::string ComparisonText(const std::vector<Searched>& searches) {
  std::vector<std::string> methods;  // in the order in which they come
  std::map<std::string, std::vector<double>> costs;
  for (const Searched& each : searches) {
    const std::string method = MethodText(each.tune.plan.method);
    if (!costs.contains(method)) methods.push_back(method);
    costs[method].push_back(each.result.tuned.Cost());
  }
  const TuneResult& first = searches.front().result;
  std::string text =
      fmt::format("{:<44} {:>9}   of each search\n",
                  fmt::format("cost on {} rows that no search saw", first.tuned.costs.size()), "median");
  const auto line = [&](const std::string& what, double cost) {
    text += fmt::format("  {:<42} {:>9.4g}", what, cost);
  };
  line("start", first.start.Cost());
  text += '\n';
  if (first.own) {
    line("the scenario's own gains", first.own->Cost());
    text += '\n';
  }
  for (const std::string& method : methods) {
    line(method, Quantile(costs[method], 0.5));
    std::sort(costs[method].begin(), costs[method].end());
    text += fmt::format("   {:.4g}\n", fmt::join(costs[method], "  "));
  }
  std::stable_sort(methods.begin(), methods.end(), [&](const std::string& a, const std::string& b) {
    return Quantile(costs[a], 0.5) < Quantile(costs[b], 0.5);
  });
  text += fmt::format("In the median of the searches, the least first: {}.\n", fmt::join(methods, ", "));
  for (const Searched& each : searches) {
    for (const std::string& broken : BrokenConstraints(each.tune, each.result)) {
      const TunePlan& plan = each.tune.plan;
      text += fmt::format("{}, seed {}: {}\n", MethodText(plan.method), plan.flights.seed, broken);
    }
  }
  return text;
}

}  // namespace kestrel::campaign
