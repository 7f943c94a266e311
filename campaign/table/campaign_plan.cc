// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/campaign_plan.h"

#include <fmt/format.h>

#include <sstream>
#include <string_view>

#include "base/file/files.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/table/flight_metrics.h"
#include "campaign/table/read_variation.h"
#include "campaign/table/sampling.h"
#include "flight/simulated/possible_metrics.h"

namespace kestrel::campaign {
namespace {

constexpr std::string_view kNoted = "# --set ";

struct CampaignFile {
  CampaignPlan plan;
  ConfigNode vary;
};

void Fields(FieldVisitor& v, CampaignFile& f) {
  v({"name", "name of the campaign and of its results; empty: that of the file"}, f.plan.name);
  v(Required("scenario", "scenario that is flown: a name, or a file beside this one"), f.plan.scenario);
  v({"set", "assignments KEY=VALUE to the scenario, for every flight"}, f.plan.set);
  v({"runs", "number of flights; with a grid: of each of its points"}, f.plan.runs, 1, kMaxRows);
  v({"seed", "seed of the samples, from which also each flight's own seed follows"}, f.plan.seed);
  v({"sampling",
     "how the varied values are drawn: independently, by Latin hypercube, or as a scrambled Sobol sequence"},
    f.plan.sampling, {"independent", "latin_hypercube", "sobol"});
  v({"vary", "by key of the scenario, the distribution from which each flight draws its value"}, f.vary);
  v({"correlated", "groups of varied keys whose values correlate"}, f.plan.correlated);
  v({"same", "keys that take the value of a varied key in each flight"}, f.plan.same);
  v({"metrics", "metrics that reports show first; empty: those of the scenario's criteria"}, f.plan.metrics);
  v({"limit_s", "longest wall-clock time of a flight; after it the flight is ended and counts as timed out"},
    f.plan.limit_s, 0.1, 1e6);
  v({"thresholds",
     "limits by metric, or by success for the share of flights that passed, which the campaign must keep to"},
    f.plan.thresholds);
}

// As the file and its overrides say it, of which nothing is resolved yet.
CampaignPlan PlanIn(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    Config& config, Mistakes& mistakes) {
  const SplitOverrides split = Split(overrides, KeysOf<CampaignFile>());
  CampaignFile read;
  config = LoadConfig(file, split.of_file, mistakes);
  flight::RenameFormerMetrics(config, {"metrics", "thresholds"});
  Read(config, read, mistakes);
  read.plan.vary = ReadVary(read.vary, mistakes);
  SetInstead(split.of_scenario, read.plan.set);
  return read.plan;
}

// Without what says what the file says already: `--runs 5` of a file of 5 runs is the same campaign.
std::vector<std::string> ThatMakeADifference(std::vector<std::string> overrides,
                                             const std::filesystem::path& file, const CampaignPlan& plan) {
  for (std::size_t i = 0; i < overrides.size();) {
    std::vector<std::string> others = overrides;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    Config config;
    Mistakes mistakes;
    if (PlanIn(file, others, config, mistakes) == plan && mistakes.empty())
      overrides = others;
    else
      ++i;
  }
  return overrides;
}

void CheckResults(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes) {
  FlightMetrics metrics(plan);
  for (std::size_t i = 0; i < plan.metrics.size(); ++i) {
    const std::string index = std::to_string(i);
    metrics.Check(plan.metrics[i], {}, WhereIn(root, {"metrics", index}), "metrics." + index, mistakes);
  }
  for (const auto& [metric, threshold] : plan.thresholds) {
    const Place& where = WhereIn(root, {"thresholds", metric});
    const std::string path = "thresholds." + metric;
    const bool reported = IsReported(mistakes, path);
    metrics.Check(metric, {"success"}, where, path, mistakes);
    if (!reported && !threshold.max && !threshold.min)
      mistakes.Add(where, path, "has no limit", "valid: max, min or both");
    if (threshold.max && threshold.min && *threshold.min > *threshold.max)
      mistakes.Add(where, path, NoneBetween(*threshold.min, *threshold.max));
    if (threshold.quantile && (*threshold.quantile <= 0 || *threshold.quantile >= 1))
      mistakes.Add(where, path + ".quantile", fmt::format("{} is out of range", *threshold.quantile),
                   "valid: between 0 and 1");
    if (metric != "success") continue;
    if (threshold.quantile)
      mistakes.Add(where, path + ".quantile", "a share of runs has none", "valid: max, min or both");
    for (const auto& limit : {threshold.max, threshold.min})
      if (limit && (*limit < 0 || *limit > 1))
        mistakes.Add(where, path, fmt::format("{} is not a share of the runs", *limit), "valid: 0 to 1");
  }
}

}  // namespace

std::vector<FieldDescription> DescribeCampaignFile() { return Describe(CampaignFile{}); }

std::string NoneBetween(double min, double max) {
  return fmt::format("min = {} is above max = {}, so that nothing keeps to both; valid: min no more than max",
                     min, max);
}

std::string NoteOfOverride(const std::string& override) { return fmt::format("\n{}{}\n", kNoted, override); }

std::vector<std::string> OverridesNotedIn(const std::string& text) {
  std::vector<std::string> overrides;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(kNoted)) overrides.push_back(line.substr(kNoted.size()));
  return overrides;
}

LoadedCampaign LoadCampaign(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  Mistakes mistakes;
  Config config;
  const CampaignPlan as_written = PlanIn(file, overrides, config, mistakes);
  if (!config.readable) mistakes.ThrowIfAny();
  CampaignPlan plan = as_written;
  ResolveVariation(file, config.root, plan, mistakes);
  CheckResults(config.root, plan, mistakes);
  mistakes.ThrowIfAny();

  std::string text = ReadFile(file);
  for (const std::string& each : ThatMakeADifference(overrides, file, as_written))
    text += NoteOfOverride(each);
  LoadedCampaign loaded{
      std::move(plan), std::move(text), {}, std::filesystem::absolute(file).lexically_normal()};
  loaded.table = DrawTable(loaded.plan);
  return loaded;
}

}  // namespace kestrel::campaign
