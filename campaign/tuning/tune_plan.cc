// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/random.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/table/flight_metrics.h"
#include "campaign/table/read_variation.h"
#include "campaign/table/sampling.h"
#include "campaign/tuning/search.h"
#include "flight/gains_file.h"
#include "flight/simulated/possible_metrics.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {
namespace {

using List = std::vector<std::string>;

struct TuneFile {
  TunePlan plan;
  ConfigNode vary;
};

void Fields(FieldVisitor& v, TuneFile& f) {
  TunePlan& p = f.plan;
  v({"name", "name of the tuning and of its results; empty: that of the file"}, p.flights.name);
  v(Required("scenario", "scenario that is flown: a name, or a file beside this one"), p.flights.scenario);
  v({"set", "assignments KEY=VALUE to the scenario, for every flight"}, p.flights.set);
  v({"seed", "seed of the search and of the samples that it flies"}, p.flights.seed);
  v({"sampling",
     "how the varied values are drawn: independently, by Latin hypercube, or as a scrambled Sobol sequence"},
    p.flights.sampling, {"independent", "latin_hypercube", "sobol"});
  v({"vary", "by key of the scenario, the distribution from which each flight draws its value"}, f.vary);
  v({"correlated", "groups of varied keys whose values correlate"}, p.flights.correlated);
  v({"same", "keys that take the value of a varied key in each flight"}, p.flights.same);
  v({"limit_s", "longest wall-clock time of a flight; after it the flight is ended and counts as timed out"},
    p.flights.limit_s, 0.1, 1e6);
  v(Required("gains", "keys of the scenario that are tuned, with their bounds"), p.gains);
  v(Required("cost", "terms of the cost by metric; their sum is to be minimal"), p.cost.terms);
  v({"constraints", "limits by metric, beyond which a flight costs a penalty"}, p.cost.constraints);
  v({"failure", "cost of a flight that does not pass its scenario's criteria"}, p.cost.failure, 0.0, 1e6);
  v({"method", "search algorithm for the gains of lowest cost"}, p.method,
    {"cma_es", "cross_entropy", "random_search"});
  v({"budget", "number of flights of the search and its leaders, without those on held-out samples"},
    p.budget, 1, kMaxRows);
  v({"rows", "number of flights of each candidate; all candidates of a round fly the same samples"}, p.rows,
    1, 100000);
  v({"leaders", "number of candidates that are flown again on fresh samples, to choose the best"}, p.leaders,
    1, 1000);
  v({"fresh_rows", "number of fresh samples that each leader flies"}, p.fresh_rows, 1, 100000);
  v({"held_out_rows",
     "number of samples that the search never sees, for the gains found and those to compare them with"},
    p.held_out_rows, 2, 100000);
  v({"held_out_seed", "seed of the held-out samples"}, p.held_out_seed);
}

// Of the resolved scenario. None: the key has no number.
std::optional<double> ValueOf(const ConfigNode& root, const std::string& key) {
  const ConfigNode* node = &root;
  std::istringstream path(key);
  for (std::string part; std::getline(path, part, '.');) {
    const auto found = std::find_if(node->members.begin(), node->members.end(),
                                    [&](const auto& member) { return member.key == part; });
    if (found == node->members.end()) return std::nullopt;
    node = &found->node;
  }
  char* end = nullptr;
  const double value = std::strtod(node->text.c_str(), &end);
  if (node->kind != ConfigNode::Kind::kText || end != node->text.c_str() + node->text.size())
    return std::nullopt;
  return value;
}

std::map<std::string, double> OwnGains(const TunePlan& plan) {
  Mistakes none;
  const Config resolved = ParseConfig(
      ToYaml(flight::LoadScenario(plan.flights.scenario, plan.flights.set).scenario), "", {}, none);
  std::map<std::string, double> own;
  for (const auto& [key, gain] : plan.gains)
    if (const auto value = ValueOf(resolved.root, key)) own[key] = *value;
  return own;
}

List OtherGains(const TunePlan& plan) {
  List others = flight::NamedGains(ScenarioFile(plan.flights.scenario), plan.flights.set).Under({});
  std::erase_if(others,
                [&](const std::string& each) { return plan.gains.contains(each.substr(0, each.find('='))); });
  return others;
}

void CheckBounds(const Gain& gain, const Place& where, const std::string& path, Mistakes& mistakes) {
  if (IsReported(mistakes, path)) return;  // and what has no number has its default
  if (gain.low >= gain.high)
    mistakes.Add(where, path, fmt::format("low = {} is not below high = {}", gain.low, gain.high));
  else if (gain.log && gain.low <= 0)
    mistakes.Add(where, path, fmt::format("low = {} has no logarithm", gain.low), "valid: above 0");
  if (gain.start && (*gain.start < gain.low || *gain.start > gain.high))
    mistakes.Add(where, path + ".start", fmt::format("{} is out of its bounds", *gain.start),
                 fmt::format("valid: {} to {}", gain.low, gain.high));
}

void CheckGains(const ConfigNode& root, const TunePlan& plan, Mistakes& mistakes) {
  if (plan.gains.empty() && !IsReported(mistakes, "gains"))
    mistakes.Add(WhereIn(root, {"gains"}), "gains", "nothing is to be tuned", "valid: one key or more");
  for (const auto& [key, gain] : plan.gains) {
    const Place& where = WhereIn(root, {"gains", key});
    const std::string path = "gains." + key;
    CheckBounds(gain, where, path, mistakes);
    const bool varies = plan.flights.vary.contains(key) ||
                        std::any_of(plan.flights.same.begin(), plan.flights.same.end(),
                                    [&key = key](const SameValue& same) { return same.key == key; });
    if (varies) mistakes.Add(where, path, "varies from flight to flight too", "valid: one of the two");
    for (const std::string& set : plan.flights.set)
      if (set.substr(0, set.find('=')) == key)
        mistakes.Add(where, path, fmt::format("is tuned, and set has '{}'", set), "valid: start");
  }
}

void CheckCost(const ConfigNode& root, const TunePlan& plan, Mistakes& mistakes) {
  const FlightCost& cost = plan.cost;
  FlightMetrics metrics(plan.flights);
  if (cost.terms.empty() && cost.constraints.empty() && !IsReported(mistakes, "cost"))
    mistakes.Add(WhereIn(root, {"cost"}), "cost", "no metric is in it", "valid: one or more");
  for (const auto& [metric, term] : cost.terms)
    metrics.Check(metric, {}, WhereIn(root, {"cost", metric}), "cost." + metric, mistakes);
  for (const auto& [metric, constraint] : cost.constraints) {
    const Place& where = WhereIn(root, {"constraints", metric});
    const bool reported = IsReported(mistakes, "constraints." + metric);
    metrics.Check(metric, {}, where, "constraints." + metric, mistakes);
    if (!reported && !constraint.max && !constraint.min)
      mistakes.Add(where, "constraints." + metric, "has no limit", "valid: max, min or both");
    if (constraint.max && constraint.min && *constraint.min > *constraint.max)
      mistakes.Add(where, "constraints." + metric, NoneBetween(*constraint.min, *constraint.max));
  }
}

// With the scenario at hand.
void CheckGainsInScenario(const ConfigNode& root, const TunePlan& plan,
                          const std::map<std::string, double>& own, Mistakes& mistakes) {
  const auto values = [](const Gain& gain) {
    return std::array{gain.low, gain.high, gain.low + 0.3819660113 * (gain.high - gain.low)};
  };
  std::vector<List> together(3);
  std::map<std::string, Gain> gains = plan.gains;
  std::erase_if(gains, [&](const auto& each) { return IsReported(mistakes, "gains." + each.first); });
  for (const auto& [key, gain] : gains)
    for (std::size_t i = 0; i < 3; ++i) together[i].push_back(fmt::format("{}={}", key, values(gain)[i]));
  const bool takes_all = TakesAll(plan.flights, together);
  for (const auto& [key, gain] : gains) {
    const Place& where = WhereIn(root, {"gains", key});
    const std::string path = "gains." + key;
    bool valid = true;
    for (const double value : values(gain)) {
      valid = takes_all || (valid && CheckOverride(plan.flights, {}, key, fmt::format("{}", value), where,
                                                   path, "", mistakes));
    }
    if (!valid || gain.start) continue;
    const auto value = own.find(key);
    if (value == own.end())
      mistakes.Add(where, path, "the scenario has no number there", "valid: with a start");
    else if (value->second < gain.low || value->second > gain.high)
      mistakes.Add(where, path, fmt::format("the scenario has {}, out of its bounds", value->second),
                   "valid: bounds around that, or a start");
  }
}

SampleTable Draw(CampaignPlan plan, int runs, std::uint64_t seed, const std::string& name) {
  plan.runs = runs;
  plan.seed = RandomStream(seed, name).Bits();
  return DrawTable(plan);
}

void CheckBudget(const ConfigNode& root, const LoadedTune& tune, Mistakes& mistakes) {
  const TunePlan& plan = tune.plan;
  Search search = MakeSearch(plan.method, Point(plan.gains.size(), 0.5), 1);
  const std::size_t candidates = std::visit([](auto& s) { return s.Ask().size(); }, search);
  const std::size_t rows = RowsOfRound(plan, 0).rows.size();
  const std::size_t least =
      (1 + candidates) * rows + static_cast<std::size_t>(plan.leaders) * tune.fresh.rows.size();
  if (static_cast<std::size_t>(plan.budget) < least)
    mistakes.Add(WhereIn(root, {"budget"}), "budget",
                 fmt::format("{} flights are not enough for the start and one round of {} candidates on {} "
                             "rows, and {} leaders on {} fresh ones",
                             plan.budget, candidates, rows, plan.leaders, tune.fresh.rows.size()),
                 fmt::format("valid: {} or more", least));
}

}  // namespace

std::vector<FieldDescription> DescribeTuneFile() { return Describe(TuneFile{}); }

SampleTable RowsOfRound(const TunePlan& plan, int round) {
  return Draw(plan.flights, plan.rows, plan.flights.seed, fmt::format("tuning rows {}", round));
}

LoadedTune LoadTune(const std::filesystem::path& file, const List& overrides) {
  Mistakes mistakes;
  const SplitOverrides split = Split(overrides, KeysOf<TuneFile>());
  Config config = LoadConfig(file, split.of_file, mistakes);
  flight::RenameFormerMetrics(config, {"cost", "constraints"});
  if (!config.readable) mistakes.ThrowIfAny();
  TuneFile read;
  Read(config, read, mistakes);
  LoadedTune tune;
  TunePlan& plan = tune.plan = std::move(read.plan);
  plan.flights.vary = ReadVary(read.vary, mistakes);
  plan.flights.runs = plan.rows;
  SetInstead(split.of_scenario, plan.flights.set);
#ifdef KESTREL_WITHOUT_PAGMO
  if (plan.method == "cma_es")
    mistakes.Add(
        WhereIn(config.root, {"method"}), "method",
        "cma_es, and this build has no pagmo; valid: cross_entropy, random_search, or build anew with "
        "Debian's libpagmo-dev");
#endif
  CheckGains(config.root, plan, mistakes);
  const bool flies = ResolveVariation(file, config.root, plan.flights, mistakes);
  CheckCost(config.root, plan, mistakes);
  if (flies) {
    tune.own = OwnGains(plan);
    tune.others = OtherGains(plan);
    CheckGainsInScenario(config.root, plan, tune.own, mistakes);
  }
  mistakes.ThrowIfAny();
  for (auto& [key, gain] : plan.gains)
    if (!gain.start) gain.start = tune.own.at(key);

  tune.fresh = Draw(plan.flights, plan.fresh_rows, plan.flights.seed, "tuning fresh rows");
  tune.held_out = Draw(plan.flights, plan.held_out_rows, plan.held_out_seed, "tuning held-out rows");
  CheckBudget(config.root, tune, mistakes);
  mistakes.ThrowIfAny();

  tune.text = ReadFile(file);
  for (const std::string& each : overrides) tune.text += NoteOfOverride(each);
  return tune;
}

}  // namespace kestrel::campaign
