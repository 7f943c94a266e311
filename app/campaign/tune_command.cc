// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/tune_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>

#include "app/campaign/command_line.h"
#include "app/option/within.h"
#include "app/run/isa_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "base/process/print_note.h"
#include "base/process/shell_word.h"
#include "base/version.h"
#include "campaign/counted.h"
#include "campaign/execution/batch_script.h"
#include "campaign/execution/run_campaign.h"
#include "campaign/named_file.h"
#include "campaign/report/html_report.h"
#include "campaign/tuning/flight_cache.h"
#include "campaign/tuning/tune.h"
#include "campaign/tuning/tune_files.h"
#include "campaign/tuning/tune_report.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> stopped = false;

constexpr std::array kMethods = {"cma_es", "cross_entropy", "random_search"};

// Of the budget, as far as the search has come.
std::int64_t FlightsUntil(const campaign::TuneResult& result) {
  return std::max(result.search.back().flights, result.flights);
}

void ShowRound(const campaign::LoadedTune& tune, const campaign::TuneResult& result) {
  PrintNote("{:>6} of {} flights   round {:>3}   cost {:.4g} at first, {} {:.4g}\n", FlightsUntil(result),
            tune.plan.budget, result.search.back().round, result.search.front().Cost(),
            result.compares_rounds ? "minimum until now" : "median of the round",
            campaign::Stages(result).back().cost);
}

// But for where the program is, and what comes of it.
std::string CommandText(const TuneArguments& a, const std::vector<std::string>& overrides) {
  std::string text = "kestrel tune " + ShellWord(a.file);
  for (const std::string& each : overrides) text += " --set " + ShellWord(each);
  if (const std::string set = ChosenInstructionSet(); !set.empty()) text += " --isa " + set;
  return text;
}

// Searches, and writes what comes of it into the folder.
campaign::Searched SearchIn(const TuneArguments& a, const fs::path& folder,
                            const std::vector<std::string>& more, campaign::SharedFlights& known) {
  std::vector<std::string> overrides = a.overrides;
  overrides.insert(overrides.end(), more.begin(), more.end());
  campaign::Searched searched{campaign::LoadTune(campaign::NamedFile("tuning", a.file), overrides), {}, {}};
  const campaign::LoadedTune& tune = searched.tune;
  fs::create_directories(folder);
  campaign::FlightCache flights(tune, folder, a.jobs > 0 ? a.jobs : campaign::Cores(), a.worker, stopped,
                                known);
  const auto kept = static_cast<std::int64_t>(flights.cached());
  if (!a.quiet && kept > 0) PrintNote("{} are there already\n", campaign::Counted(kept, "flight"));
  const campaign::TuneResult& result = searched.result =
      campaign::Tune(tune, std::ref(flights), [&](const campaign::TuneResult& r) {
        if (!a.quiet && FlightsUntil(r) > kept) ShowRound(tune, r);  // what is only read again is no news
      });
  WriteFile(folder / "gains.yaml", campaign::GainsFile(tune, result, CommandText(a, overrides), Version()));
  WriteFile(folder / "tuning.json", campaign::TuneJson(tune, result, Version()));
  searched.runs = flights.Rows(result.tuned.flights - static_cast<std::int64_t>(result.tuned.costs.size()),
                               result.tuned.flights);
  return searched;
}

// Before the first of them flies.
void RequireAllMethods(const TuneArguments& a) {
  Mistakes mistakes;
  for (const std::string method : kMethods) {
    std::vector<std::string> overrides = a.overrides;
    overrides.push_back("method=" + method);
    try {
      campaign::LoadTune(campaign::NamedFile("tuning", a.file), overrides);
    } catch (const InputError& e) {
      for (Diagnostic each : e.diagnostics) {
        each.what += fmt::format(" ({})", method);
        mistakes.Add(std::move(each));
      }
    }
  }
  mistakes.ThrowIfAny();
}

std::string AgainText(const TuneArguments& a) {
  std::string text = "./" + CommandText(a, a.overrides);
  if (a.compare > 0) text += fmt::format(" --compare {}", a.compare);
  if (!a.out.empty()) text += " --out " + ShellWord(a.out);
  return text;
}

}  // namespace

CLI::App* AddTuneCommand(CLI::App& app, TuneArguments& a) {
  CLI::App* command = app.add_subcommand("tune", "Look for the gains of lowest cost, by many flights");
  command->add_option("file", a.file, "A tuning's YAML file, or the name of one that `list tunings` shows")
      ->type_name("TUNING");
  command
      ->add_option("--set", a.overrides,
                   "key.path=value, instead of the file's; of a key that only its scenario has, for every "
                   "flight; may be "
                   "repeated")
      ->type_name("KEY=VALUE");
  command->add_option("--compare", a.compare, "Search by every method, so many times each, and compare them")
      ->check(WholeNumber(1, 100));
  command->add_option("--jobs", a.jobs, "Flights at the same time (default: one for each core)")
      ->check(WholeNumber(1, 1024));
  command->add_option("--out", a.out, "Folder for what comes of it (default results/tunings/SCENARIO/NAME)")
      ->type_name("DIR")
      ->check(NotEmpty);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "It writes gains.yaml, which a scenario takes (--set gains=FILE), and report.html. Interrupted, it "
      "goes on where it was. Exit status 1: the gains found were not shown to be better than those it began "
      "with.\n\n"
      "A tuning's file has, of a campaign's: scenario, set, vary, correlated, same, sampling, seed, limit_s; "
      "and\n"
      "  gains          KEY: {low, high, log: looked for on a log scale, start: instead of the scenario's}\n"
      "  cost           METRIC: {scale, weight, worst, wanted}: weight * metric / scale, the metric no more "
      "than\n"
      "                 worst (10 scales), which it also is of a flight without it; with wanted, what it "
      "lacks\n"
      "                 of that stands for the metric\n"
      "  constraints    METRIC: {max, min, penalty (5)}: a flight beyond costs once to twice the penalty\n"
      "  failure        cost of a flight that does not pass (0)\n"
      "  method         cma_es, cross_entropy, random_search\n"
      "  budget         flights of the search and its leaders (500)\n"
      "  rows           flights of each candidate (2); the candidates of a round fly the same\n"
      "  leaders        gains flown again (5), on fresh_rows (10)\n"
      "  held_out_rows  for the gains found and those to compare them with (50); held_out_seed (1)\n\n"
      "Examples:\n  kestrel tune hover/poor\n"
      "  kestrel tune hover/poor --set method=random_search --set seed=2 --out "
      "/tmp/random\n"
      "  kestrel tune hover/poor --compare 5\n"
      "  kestrel run hover --set gains=results/tunings/hover/poor/gains.yaml");
  return command;
}

bool TuneCommand(const TuneArguments& a) {
  if (a.file.empty()) throw InputError({}, NoneNamed("tuning"));
  EndOnInterrupt();
  const campaign::LoadedTune tune = campaign::LoadTune(campaign::NamedFile("tuning", a.file), a.overrides);
  const campaign::CampaignPlan& flights = tune.plan.flights;
  const fs::path folder = a.out.empty()
                              ? fs::path("results/tunings") / fs::path(flights.scenario).stem() / flights.name
                              : fs::path(a.out);
  Mistakes mistakes;
  CheckWritableFolder(folder, "--out", mistakes);
  RefuseReportOf("campaign", campaign::ResultFile(folder), mistakes);
  mistakes.ThrowIfAny();
  if (a.compare > 0) RequireAllMethods(a);
  OnEndSignals([](int) { stopped = true; });
  campaign::SharedFlights known;
  std::vector<campaign::Searched> searches;
  if (a.compare == 0) searches.push_back(SearchIn(a, folder, {}, known));
  for (const char* method : kMethods) {
    for (int repetition = 0; repetition < a.compare; ++repetition) {
      const std::uint64_t seed = tune.plan.flights.seed + static_cast<std::uint64_t>(repetition);
      const std::string name = fmt::format("{}-{}", method, seed);
      if (!a.quiet) PrintNote("{}\n", name);
      searches.push_back(SearchIn(a, folder / name,
                                  {fmt::format("method={}", method), fmt::format("seed={}", seed)}, known));
    }
  }
  EndOnNextSignal();
  const fs::path gains = a.compare == 0 ? folder : folder / fmt::format("cma_es-{}", tune.plan.flights.seed);
  WriteFile(folder / "report.html",
            campaign::HtmlReport(campaign::TuneSubject(searches, gains, AgainText(a)), folder));
  const campaign::TuneResult& first = searches.front().result;
  if (!a.quiet) {
    fmt::print("{}  {}\n  {}\n",
               a.compare == 0 ? campaign::TuneText(tune, first) : campaign::ComparisonText(searches),
               (gains / "gains.yaml").string(), (folder / "report.html").string());
  }
  return first.Better();
}

}  // namespace kestrel::app
