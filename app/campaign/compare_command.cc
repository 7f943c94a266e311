// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/compare_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/user_file.h"
#include "campaign/statistics/comparison.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

fs::path ResultsOf(const std::string& given, const char* which, Mistakes& mistakes) {
  const fs::path named = fs::path("results/campaigns") / given / "results.sqlite";
  for (const fs::path& file : {fs::path(given), fs::path(given) / "results.sqlite", named})
    if (IsFile(file)) return file;
  mistakes.Add(
      which, "", fmt::format("'{}' has no results", given),
      "valid: a result file, a folder with results.sqlite, or the name of a campaign in results/campaigns");
  return {};
}

}  // namespace

CLI::App* AddCompareCommand(CLI::App& parent, CompareArguments& a) {
  CLI::App* command = parent.add_subcommand(
      "compare",
      "Two campaigns on the same rows, row by row: is B better than A, worse, or is it not shown?");
  command->add_option("A", a.a, "A result file, its folder, or a campaign's name")
      ->type_name("CAMPAIGN")
      ->required();
  command->add_option("B", a.b, "The same of the other one")->type_name("CAMPAIGN")->required();
  command
      ->add_option("--metric", a.metrics,
                   "To compare beside success (default: those that the campaigns list); may be repeated")
      ->allow_extra_args(false);
  command->add_option("--json", a.json, "Also write the comparison as JSON to this file")->type_name("FILE");
  command->add_option("--seed", a.seed, "Of the bootstrap")->capture_default_str();
  command->footer(
      "Exit status 1: B is worse.\n\nExamples:\n"
      "  kestrel campaign compare landing_dispersion landing_new_gains\n"
      "  kestrel campaign compare before/results.sqlite after/results.sqlite --metric touchdown_error_m");
  return command;
}

bool CompareCommand(const CompareArguments& a) {
  Mistakes mistakes;
  const fs::path file_a = ResultsOf(a.a, "A", mistakes), file_b = ResultsOf(a.b, "B", mistakes);
  CheckWritableFile(a.json, "--json", mistakes);
  mistakes.ThrowIfAny();
  const auto read = [](const fs::path& file) {
    const campaign::ResultStore store = campaign::ResultStore::ReadCampaign(file);
    return campaign::CampaignResults{store.identity(), store.Results()};
  };
  const campaign::CampaignResults results_a = read(file_a), results_b = read(file_b);
  const campaign::Comparison comparison = campaign::Compare(results_a, results_b, a.metrics, a.seed);
  fmt::print("A: {}, {}\nB: {}, {}\n{}", results_a.identity.name, file_a.string(), results_b.identity.name,
             file_b.string(), campaign::ToText(comparison));
  if (!a.json.empty()) WriteFile(a.json, campaign::ToJson(comparison));
  return comparison.verdict != campaign::Verdict::kWorse;
}

}  // namespace kestrel::app
