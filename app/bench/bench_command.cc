// SPDX-License-Identifier: Apache-2.0
#include "app/bench/bench_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "app/bench/bench_list.h"
#include "app/option/one_of.h"
#include "app/option/within.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "bench/timings/bench_timings.h"
#include "bench/timings/timing_server.h"

namespace kestrel::app {
namespace {

using Kind = Bench::Kind;

std::vector<std::string> Names(bool (*which)(const Bench&)) {
  std::vector<std::string> names;
  for (const Bench& bench : Benches())
    if (which(bench)) names.push_back(bench.name);
  return names;
}

// Those that `kestrel bench NAME` runs.
std::vector<const Bench*> Chosen(const std::string& name) {
  std::vector<const Bench*> chosen;
  for (const Bench& bench : Benches())
    if (name.empty() ? bench.kind == Kind::kGeneral : bench.name == name) chosen.push_back(&bench);
  return chosen;
}

// An option that no chosen bench takes would be left out without a word.
void RefuseUseless(const CLI::App& command, const std::string& name) {
  const std::vector<const Bench*> chosen = Chosen(name);
  std::vector<std::string> refusals;
  for (const char* option : {"--fov-deg", "--seeds", "--jobs", "--out", "--backend", "--against", "--rounds",
                             "--clock", "--in-turn"}) {
    const auto takes = [&](const Bench& bench) { return bench.Takes(option); };
    if (command.count(option) == 0 ||
        std::any_of(chosen.begin(), chosen.end(), [&](const Bench* each) { return takes(*each); }))
      continue;
    std::vector<std::string> valid;
    for (const Bench& bench : Benches())
      if (takes(bench)) valid.push_back(bench.name);
    refusals.push_back(fmt::format("{} is of no use to {}; valid: with {}", option,
                                   name.empty() ? "bench without a name" : "bench " + name,
                                   fmt::join(valid, ", ")));
  }
  if (!refusals.empty()) throw CLI::ValidationError(fmt::format("{}", fmt::join(refusals, "\n")));
}

bool Timings(const BenchArguments& a) {
  if (a.in_turn) {
    bench::ServeTimings(std::cin, std::cout);
    return true;
  }
  const auto clock = a.clock == "wall" ? bench::TimingClock::kWall : bench::TimingClock::kProcessor;
  return bench::BenchTimings({.rounds = a.rounds, .clock = clock, .against = a.against, .json = a.json});
}

}  // namespace

CLI::App* AddBenchCommand(CLI::App& app, BenchArguments& a) {
  CLI::App* command = app.add_subcommand("bench", "Measure: a table of figures beside their targets");
  const auto by_name = Names([](const Bench& bench) { return bench.kind != Kind::kGeneral; });
  command->add_option("name", a.name, fmt::format("All but {} when none is given", fmt::join(by_name, ", ")))
      ->check(OneOf(Names([](const Bench&) { return true; })));
  command
      ->add_option("pictures", a.pictures,
                   "Of horizon_pictures and horizon_training: a folder of photographs, with label.csv "
                   "(filename,slope,offset; none,none where no horizon is in view) or without")
      ->type_name("DIR");
  command
      ->add_option("--fov-deg", a.fov_deg,
                   "Of horizon_pictures and horizon_training: what the longer side of the photographs sees")
      ->check(Within(5.0, 120.0))
      ->capture_default_str();
  command->add_option("--seeds", a.seeds, "A..B, first and last")->capture_default_str();
  command->add_option("--jobs", a.jobs, "Flights at the same time")
      ->check(WholeNumber(1, 256))
      ->capture_default_str();
  command->add_option("--json", a.json, "Also write the figures as JSON to this file")
      ->check(NotEmpty)
      ->type_name("FILE");
  command->add_option("--out", a.out, "Folder where each bench that leaves files has one of its name")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--backend", a.backend, "What OpenGL draws by in render and frames")
      ->check(OneOf({"osmesa", "egl"}))
      ->capture_default_str();
  command
      ->add_option(
          "--against", a.against,
          "Of timings: what to compare with. A program kestrel of another build, which runs in turn "
          "with this one and shows 5 %; or what --json wrote on this machine before, which shows less")
      ->check([](const std::string& file) {
        return file.empty() ? "no file; valid: a program kestrel, or what --json wrote" : "";
      })
      ->type_name("FILE");
  command
      ->add_option("--rounds", a.rounds,
                   "Of timings: processes of each program that are timed; of fewer nothing follows")
      ->check(WholeNumber(9, 200))
      ->capture_default_str();
  command
      ->add_option("--clock", a.clock,
                   "Of timings: the processor's time of all threads, or the wall's, which has what else the "
                   "machine does in it")
      ->check(OneOf({"processor", "wall"}))
      ->capture_default_str();
  command
      ->add_flag("--in-turn", a.in_turn,
                 "Of timings: answer another program, that reads names of work from here line by line")
      ->group("");
  command->parse_complete_callback([command, &a] { RefuseUseless(*command, a.name); });
  command->footer(
      "Examples:\n  kestrel bench flights --seeds 1..20\n  kestrel bench render\n"
      "  kestrel bench timings --against build/kestrel-before");
  return command;
}

bool BenchCommand(const BenchArguments& arguments) {
  const std::vector<const Bench*> chosen = Chosen(arguments.name);
  Mistakes mistakes;
  CheckWritableFile(arguments.json, "--json", mistakes);
  const std::filesystem::path out = arguments.out;
  if (std::any_of(chosen.begin(), chosen.end(), [](const Bench* each) { return each->Takes("--out"); }))
    CheckWritableFolder(out, "--out", mistakes);
  // They empty their folder, which is never one of the user's.
  if (arguments.name == "campaign" || arguments.name == "throughput")
    CheckWritableFolder(out / arguments.name, "the working directory", mistakes);
  const bool of_training = arguments.name == "horizon_training";
  const bool of_photographs = of_training || arguments.name == "horizon_pictures";
  std::vector<bench::Photograph> photographs;
  if (of_photographs) photographs = bench::ReadPhotographs(arguments.pictures, mistakes);
  if (!of_photographs && !arguments.pictures.empty())
    mistakes.Add("bench", arguments.name, arguments.pictures,
                 "valid: a folder after horizon_pictures or horizon_training alone");
  if (of_training && !photographs.empty() &&
      std::none_of(photographs.begin(), photographs.end(), [](const auto& p) { return p.labelled; }))
    mistakes.Add("bench", arguments.name, "no photograph there has a label",
                 "valid: a folder with label.csv (filename,slope,offset)");
  flight::SeedRange seeds;
  try {
    seeds = flight::ParseSeeds(arguments.seeds);
  } catch (const InputError& error) {
    mistakes.Add(error);
  }
  mistakes.ThrowIfAny();
  if (arguments.name == "timings") return Timings(arguments);
  std::vector<records::Figure> table;
  for (const Bench* bench : chosen) bench->run({arguments, seeds, out / bench->name, photographs}, table);
  if (chosen.front()->kind != Kind::kOfOwnTables) records::PrintFigures(table);
  if (!arguments.json.empty()) records::WriteFigures(arguments.json, table);
  return records::AllMet(table);
}

}  // namespace kestrel::app
