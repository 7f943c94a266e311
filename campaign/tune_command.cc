// SPDX-License-Identifier: Apache-2.0
#include "campaign/tune_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "campaign/execution/result_store.h"
#include "campaign/execution/run_campaign.h"
#include "campaign/execution/worker_pool.h"
#include "campaign/tuning/tune.h"
#include "campaign/tuning/tune_files.h"
#include "scenarios/files.h"
#include "scenarios/scenario.h"
#include "scenarios/version.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> stopped = false;

// A row for each flight that a tuning can come to; what it flies with is known only then.
SampleTable FlightsOf(const LoadedTune& tune) {
  SampleTable table{{"flight"}, {}};
  const std::size_t most = static_cast<std::size_t>(tune.plan.budget) + 3 * tune.held_out.rows.size();
  for (std::size_t i = 0; i < most; ++i) table.rows.push_back({std::to_string(i)});
  return table;
}

CampaignIdentity IdentityOf(const LoadedTune& tune) {
  const CampaignPlan& flights = tune.plan.flights;
  return {flights.name, ToYaml(LoadScenario(flights.scenario, flights.set).scenario), tune.text, Version(),
          FlightsOf(tune)};
}

// Flies what is not kept already, and keeps it.
class KeptFlights {
 public:
  KeptFlights(const LoadedTune& tune, const fs::path& folder, int jobs, std::vector<std::string> worker)
      : store_(ResultStore::Open(folder / "flights.sqlite", IdentityOf(tune))),
        jobs_(jobs),
        limit_s_(tune.plan.flights.limit_s),
        logs_(folder / "logs"),
        worker_(std::move(worker)) {
    for (RunResult& result : store_.Results()) {
      const std::int64_t row = result.row;
      kept_.emplace(row, std::move(result));
    }
  }
  std::size_t kept() const { return kept_.size(); }

  std::vector<RunResult> operator()(const std::vector<RunOrder>& orders) {
    std::vector<RunResult> results;
    std::vector<const RunOrder*> missing;
    for (const RunOrder& order : orders) {
      if (const auto kept = kept_.find(order.row); kept != kept_.end())
        results.push_back(kept->second);
      else
        missing.push_back(&order);
    }
    if (!missing.empty() && !pool_) pool_.emplace(jobs_, limit_s_, logs_, worker_);
    for (auto next = missing.begin(); next != missing.end() || (pool_ && pool_->under_way() > 0);) {
      if (stopped) throw std::runtime_error("interrupted; the same command goes on from here");
      while (next != missing.end() && pool_->Idle()) pool_->Give(**next++);
      if (auto result = pool_->Take(0.2)) {
        store_.Put(*result);
        results.push_back(std::move(*result));
      }
    }
    return results;
  }

 private:
  ResultStore store_;
  int jobs_;
  double limit_s_;
  fs::path logs_;
  std::vector<std::string> worker_;
  std::map<std::int64_t, RunResult> kept_;
  std::optional<WorkerPool> pool_;
};

void ShowRound(const LoadedTune& tune, const TuneResult& result) {
  const auto least = std::min_element(result.search.begin(), result.search.end(),
                                      [](const auto& a, const auto& b) { return a.Cost() < b.Cost(); });
  fmt::print(stderr, "{:>6} of {} flights   round {:>3}   cost {:.4g} at first, least {:.4g}\n",
             std::max(result.search.back().flights, result.flights), tune.plan.budget,
             result.search.back().round, result.search.front().Cost(), least->Cost());
}

}  // namespace

CLI::App* AddTuneCommand(CLI::App& app, TuneArguments& a) {
  CLI::App* command = app.add_subcommand("tune", "Look for the gains of least cost, by many flights");
  command->add_option("file", a.file, "A tuning's YAML file")->required();
  command->add_option("--set", a.overrides, "key.path=value, instead of the file's; may be repeated");
  command->add_option("--jobs", a.jobs, "Flights at the same time (default: one for each core)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--out", a.out, "Folder for what comes of it (default results/tunings/NAME)");
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "It writes gains.yaml, which a scenario takes: --set gains=FILE. Interrupted, it goes on where it "
      "was.\n\n"
      "Examples:\n  kestrel tune scenarios/hover/tunings/poor.yaml\n"
      "  kestrel tune scenarios/hover/tunings/poor.yaml --set method=random_search --set seed=2 --out "
      "/tmp/random\n"
      "  kestrel run hover --set gains=results/tunings/poor/gains.yaml");
  return command;
}

bool TuneCommand(const TuneArguments& a) {
  const LoadedTune tune = LoadTune(a.file, a.overrides);
  const fs::path folder =
      a.out.empty() ? fs::path("results/tunings") / tune.plan.flights.name : fs::path(a.out);
  Mistakes mistakes;
  CheckWritableFolder(folder, "--out", mistakes);
  mistakes.ThrowIfAny();
  fs::create_directories(folder);
  KeptFlights flights(tune, folder, a.jobs > 0 ? a.jobs : Cores(), a.worker);
  if (!a.quiet && flights.kept() > 0) fmt::print(stderr, "{} flights are there already\n", flights.kept());
  stopped = false;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = true; });
  const TuneResult result = Tune(tune, std::ref(flights), [&](const TuneResult& r) {
    if (!a.quiet) ShowRound(tune, r);
  });
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  WriteFile(folder / "gains.yaml", GainsFile(tune, result, a.file, Version()));
  WriteFile(folder / "tuning.json", TuneJson(tune, result, Version()));
  if (!a.quiet) fmt::print("{}  {}\n", TuneText(tune, result), (folder / "gains.yaml").string());
  return result.Better();
}

}  // namespace kestrel
