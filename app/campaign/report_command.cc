// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/report_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/campaign/campaign_command.h"
#include "app/campaign/command_line.h"
#include "app/option/within.h"
#include "app/run/isa_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/shell_word.h"
#include "base/user_file.h"
#include "campaign/execution/batch_script.h"
#include "campaign/statistics/results_csv.h"
#include "sim/render/ray/instruction_set.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

// The options with which a campaign was flown.
std::string OptionsOf(const campaign::CampaignIdentity& identity, const fs::path& folder) {
  std::string options;
  for (const std::string& each : campaign::OverridesNotedIn(identity.plan))
    options += " --set " + ShellWord(each);
  if (folder.lexically_normal() != fs::path("results/campaigns") / identity.name)
    options += " --out " + ShellWord(folder.empty() ? "." : folder.string());
  // That which its rows were flown by, unless it is what is taken here in any case.
  if (const auto set = identity.machine.find("instruction_set");
      set != identity.machine.end() &&
      (!ChosenInstructionSet().empty() || set->second != sim::InstructionSet()))
    options += " --isa " + ShellWord(set->second);
  return options;
}

std::map<std::string, campaign::Threshold> ThresholdsOf(const campaign::CampaignIdentity& identity) {
  constexpr std::string_view kThresholds = "thresholds.";
  std::map<std::string, campaign::Threshold> thresholds;
  for (const auto& [key, text] : campaign::ValuesOf(identity.plan, "plan")) {
    const std::size_t dot = key.rfind('.');
    const auto value = campaign::NumberIn(text);
    if (!key.starts_with(kThresholds) || dot < kThresholds.size() || !value) continue;
    campaign::Threshold& threshold = thresholds[key.substr(kThresholds.size(), dot - kThresholds.size())];
    const std::string what = key.substr(dot + 1);
    (what == "min" ? threshold.min : what == "max" ? threshold.max : threshold.quantile) = *value;
  }
  return thresholds;
}

// The file of a campaign by its name.
fs::path FileNamed(const std::string& name) {
  try {
    return CampaignFile(name);
  } catch (const InputError&) {
    return {};
  }
}

// What the program finds the campaign's file by: its name or itself; where it is no more, the name of that
// which the page offers to save.
std::string NameOf(const campaign::CampaignIdentity& identity) {
  const fs::path named = FileNamed(identity.name), file = identity.file;
  if (!IsFile(file)) return named.empty() ? identity.name + ".yaml" : identity.name;
  if (SameFile(named, file)) return identity.name;
  const std::string near = file.lexically_proximate(fs::current_path()).string();
  return near.starts_with("..") ? file.string() : near;
}

bool IsResults(const fs::path& file) { return HasEnding(file, {".sqlite", ".db"}); }

}  // namespace

campaign::ReportSubject SubjectOf(const fs::path& results, const std::string& campaign) {
  const campaign::ResultStore store = campaign::ResultStore::ReadCampaign(results);
  campaign::ReportSubject subject;
  subject.identity = store.identity();
  subject.results = store.Results();
  subject.results_file = results.string();
  const std::string name = ShellWord(campaign.empty() ? NameOf(subject.identity) : campaign);
  const std::string options = OptionsOf(subject.identity, results.parent_path());
  subject.replay = fmt::format("./kestrel campaign replay {}{}", name, options);
  subject.again = fmt::format("./kestrel campaign {}{}", name, options);
  subject.summary =
      campaign::Summarise(subject.identity, subject.results, ThresholdsOf(subject.identity), subject.replay);
  return subject;
}

CLI::App* AddCampaignReportCommand(CLI::App& campaign, CampaignReportArguments& a) {
  CLI::App* command = campaign.add_subcommand(
      "report", "Write report.html, runs.csv and summary.json of what has a result, beside the results");
  command
      ->add_option("file", a.of,
                   "A campaign's YAML file or name, or its results.sqlite, or the folder of that")
      ->type_name("CAMPAIGN")
      ->required();
  command->add_option("--out", a.out, "Folder of the results (default results/campaigns/NAME)")
      ->type_name("DIR")
      ->check(NotEmpty);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Exit status 1: a threshold is not kept.\n\nExamples:\n  kestrel campaign report dispersion\n"
      "  kestrel campaign report results/campaigns/dispersion/results.sqlite");
  return command;
}

bool CampaignReportCommand(const CampaignReportArguments& a) {
  fs::path results = a.of;
  std::error_code none;
  if (a.out.empty() && fs::is_directory(results, none)) results /= "results.sqlite";
  const bool of_results = IsResults(results);
  if (!of_results) {
    const fs::path folder =
        a.out.empty() ? fs::path("results/campaigns") / campaign::LoadCampaign(CampaignFile(a.of)).plan.name
                      : fs::path(a.out);
    results = folder / "results.sqlite";
  }
  const fs::path folder = results.parent_path(), page = folder / "report.html";
  Mistakes mistakes;
  CheckWritableFolder(folder, a.out.empty() ? "report" : "--out", mistakes);
  mistakes.ThrowIfAny();
  const campaign::ReportSubject subject = SubjectOf(results, of_results ? std::string() : a.of);
  WriteFile(page, campaign::HtmlReport(subject, folder));
  WriteFile(folder / "runs.csv", campaign::ToCsv(subject.identity.table, subject.results));
  WriteFile(folder / "summary.json", campaign::ToJson(subject.summary));
  if (!a.quiet) fmt::print("{}{}\n", campaign::ToText(subject.summary), page.string());
  const auto& judged = subject.summary.thresholds;
  return std::all_of(judged.begin(), judged.end(),
                     [](const campaign::JudgedThreshold& t) { return t.passed; });
}

}  // namespace kestrel::app
