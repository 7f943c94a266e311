// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/encounters_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>

#include "app/option/within.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/writer_lock.h"
#include "base/process/in_parallel.h"
#include "base/share_interval.h"
#include "base/statistics.h"
#include "base/user_file.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/encounter/encounter.h"
#include "flight/simulated/runner.h"
#include "flight/simulated/scenario.h"
#include "records/figures.h"
#include "records/plot/gnuplot.h"
#include "scenarios/avoid/avoid.h"
#include "sim/machine.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

constexpr double kAfterTwin_s = 3, kAfter_s = 14, kCourseAfter_s = 6;  // the meeting
constexpr std::uint64_t kHarmlessSeeds = 1000000;                      // so far from those of the near ones

struct Outcome {
  bool harmless = false;
  std::uint64_t seed = 0;
  std::string kind;
  double own_speed_m_s = 0, planned_miss_m = 0;
  double closest_without_m = 0, closest_without_s = 0;  // of near ones
  double closest_m = 0;
  bool manoeuvred = false;
  double manoeuvre_s = 0, path_excess = 0;
  auto Key() const { return std::pair(harmless, seed); }
};

constexpr const char* kRowHeader =
    "harmless,seed,kind,own_speed_m_s,planned_miss_m,closest_without_m,closest_without_s,closest_m,"
    "manoeuvred,"
    "manoeuvre_s,path_excess\n";

std::string LineOf(const Outcome& o) {
  return fmt::format("{:d},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:d},{:.17g},{:.17g}\n", o.harmless,
                     o.seed, o.kind, o.own_speed_m_s, o.planned_miss_m, o.closest_without_m,
                     o.closest_without_s, o.closest_m, o.manoeuvred, o.manoeuvre_s, o.path_excess);
}

// None: the line is not whole.
std::optional<Outcome> OutcomeOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (cells.size() != 11) return std::nullopt;
  const auto number = [&](std::size_t i) { return std::strtod(cells[i].c_str(), nullptr); };
  return Outcome{cells[0] == "1", std::strtoull(cells[1].c_str(), nullptr, 10),
                 cells[2],        number(3),
                 number(4),       number(5),
                 number(6),       number(7),
                 cells[8] == "1", number(9),
                 number(10)};
}

std::map<std::pair<bool, std::uint64_t>, Outcome> ReadOutcomes(const fs::path& file) {
  std::map<std::pair<bool, std::uint64_t>, Outcome> outcomes;
  const std::string text = ReadFile(file);
  std::size_t begin = text.find('\n');
  while (begin != std::string::npos) {  // what has no end of line was cut off
    const std::size_t end = text.find('\n', ++begin);
    if (end == std::string::npos) break;
    if (const auto outcome = OutcomeOf(text.substr(begin, end - begin))) outcomes[outcome->Key()] = *outcome;
    begin = end;
  }
  return outcomes;
}

std::map<std::string, double> Fly(const flight::LoadedScenario& base, const flight::EncounterPlan& plan,
                                  std::uint64_t seed, bool avoids, double after_s,
                                  const flight::RunOptions& options = {}) {
  flight::LoadedScenario loaded = base;
  scenarios::AvoidFlight& flight = *loaded.scenario.flight.As<scenarios::AvoidFlight>();
  flight.avoids = avoids;
  flight.speed_m_s = plan.own_speed_m_s;
  flight.course_m = plan.own_speed_m_s * (plan.meets_s + kCourseAfter_s);
  loaded.scenario.seed = loaded.simulator.seed = loaded.simulator.scene.seed = seed;
  loaded.simulator.targets = plan.targets;
  loaded.simulator.start.offset_m.setZero();
  loaded.simulator.start.scatter_m = loaded.simulator.start.yaw_deg = loaded.simulator.start.yaw_scatter_deg =
      0;
  loaded.simulator.duration_s = plan.meets_s + after_s;
  const flight::FlightResult result = flight::RunFlight(loaded, options);
  if (!result.summary.complete)
    throw std::runtime_error(fmt::format("encounter {}: {}", seed, result.summary.error));
  return result.summary.metrics;
}

Outcome Meet(const flight::LoadedScenario& base, bool harmless, std::uint64_t seed,
             const flight::RunOptions& options) {
  flight::EncounterLimits limits = harmless ? flight::kHarmless : flight::kNear;
  limits.radius_m = base.scenario.flight.As<scenarios::AvoidFlight>()->avoidance.safe_m / 2;
  const flight::EncounterPlan plan =
      flight::DrawEncounter(seed, limits, base.simulator.start.height_m,
                            base.simulator.autopilot.acceleration_limit_m_s2, base.simulator.targets);
  Outcome o{harmless, seed, flight::NameOf(plan.kind), plan.own_speed_m_s, plan.miss_m};
  if (!harmless) {
    const auto without = Fly(base, plan, seed, false, kAfterTwin_s);
    o.closest_without_m = without.at("closest_m"), o.closest_without_s = without.at("closest_s");
  }
  const auto with = Fly(base, plan, seed, true, harmless ? kAfterTwin_s : kAfter_s, options);
  o.closest_m = with.at("closest_m");
  o.manoeuvred = with.at("manoeuvred") > 0;
  if (o.manoeuvred) o.manoeuvre_s = with.at("manoeuvre_s");
  o.path_excess = with.at("path_excess");
  return o;
}

// Of two counts of rare events in equally many trials: the ratio with < without, with its 95 % interval.
// Given their sum, `with` is binomial (Przyborowski, Wilenski 1940); the pairing is left out of account,
// which makes the interval wider than it need be.
struct RiskRatio {
  double ratio = 0, low = 0, high = 0;
};
RiskRatio RiskRatioOf(int with, int without) {
  const Interval share = ShareInterval(with, with + without);
  const auto odds = [](double p) { return p / (1 - p); };
  return {static_cast<double>(with) / without, odds(share.low), odds(share.high)};
}

void Draw(const fs::path& file, const std::vector<double>& without, const std::vector<double>& with,
          double radius_m) {
  std::string script;
  const auto block = [&](const char* name, std::vector<double> values) {
    std::sort(values.begin(), values.end());
    script += fmt::format("${} << END\n", name);
    for (std::size_t i = 0; i < values.size(); ++i)
      script += fmt::format("{:.6g} {:.6g}\n", values[i],
                            100.0 * static_cast<double>(i + 1) / static_cast<double>(values.size()));
    script += "END\n";
  };
  block("without", without), block("with", with);
  script += fmt::format(
      "set title 'Closest distance of {} encounters'\nset xlabel 'closest distance, m'\nset ylabel 'share of "
      "the "
      "encounters at most as close, %'\nset grid\nset key bottom right\nset xrange [0:20]\nset yrange "
      "[0:100]\n"
      "set arrow from {},0 to {},100 nohead dt 2 lc rgb '#cc0000'\nset label 'R' at {},103 center\n"
      "plot $without using 1:2 with steps lw 2 lc rgb '#888888' title 'without avoidance', $with using 1:2 "
      "with "
      "steps lw 2 lc rgb '#0060c0' title 'with avoidance'\n",
      with.size(), radius_m, radius_m, radius_m);
  records::DrawPng(file, 900, 600, script);
}

std::vector<records::Figure> TableOf(const std::vector<Outcome>& outcomes, double radius_m) {
  std::vector<double> with, without, lead, excess;
  std::map<std::string, std::array<int, 3>> kinds;  // encounters, under R without, with
  int harmless = 0, needless = 0;
  for (const Outcome& o : outcomes) {
    if (o.harmless) {
      ++harmless, needless += o.manoeuvred;
      continue;
    }
    without.push_back(o.closest_without_m), with.push_back(o.closest_m), excess.push_back(o.path_excess);
    if (o.manoeuvred) lead.push_back(o.closest_without_s - o.manoeuvre_s);
    for (const std::string& kind : {o.kind, std::string("all")}) {
      auto& [n, hit_without, hit_with] = kinds[kind];
      ++n, hit_without += o.closest_without_m < radius_m, hit_with += o.closest_m < radius_m;
    }
  }
  std::vector<records::Figure> table;
  const auto add = [&](const std::string& name, double value, const char* unit,
                       std::optional<double> target = {}) {
    table.push_back({name, value, unit, target, false, ""});
  };
  for (const auto& [kind, counts] : kinds) {
    add(fmt::format("{}: near encounters", kind), counts[0], "");
    add(fmt::format("{}: nearer than R without avoidance", kind), counts[1], "");
    add(fmt::format("{}: nearer than R with it", kind), counts[2], "");
  }
  if (!with.empty() && kinds["all"][1] > 0) {
    const RiskRatio risk = RiskRatioOf(kinds["all"][2], kinds["all"][1]);
    add("risk ratio", risk.ratio, "", 0.05);
    add("risk ratio, lower end of its 95 % interval", risk.low, "");
    add("risk ratio, upper end of its 95 % interval", risk.high, "");
  }
  if (!with.empty()) {
    for (const auto& [q, name] :
         {std::pair(0.01, "1st percentile"), {0.05, "5th percentile"}, {0.5, "median"}}) {
      add(fmt::format("closest distance without avoidance, {}", name), Quantile(without, q), "m");
      add(fmt::format("closest distance with it, {}", name), Quantile(with, q), "m");
    }
    add("manoeuvres of near encounters", static_cast<double>(lead.size()) / static_cast<double>(with.size()),
        "share");
    add("manoeuvre before the closest instant, 5th percentile", Quantile(lead, 0.05), "s");
    add("manoeuvre before the closest instant, median", Quantile(lead, 0.5), "s");
    add("path longer than straight, median", Quantile(excess, 0.5), "share");
  }
  if (harmless > 0) {
    add("harmless encounters", harmless, "");
    add("harmless encounters with a manoeuvre", static_cast<double>(needless) / harmless, "share", 0.02);
  }
  return table;
}

flight::LoadedScenario Load(const EncountersArguments& a, std::string& settings) {
  flight::LoadedScenario base = flight::LoadScenario(a.scenario, a.overrides);
  Mistakes mistakes;
  const auto* flight = base.scenario.flight.As<scenarios::AvoidFlight>();
  if (!flight) {
    mistakes.Add(a.scenario, "mission", fmt::format("'{}' avoids nobody", base.scenario.mission),
                 "valid: a scenario of the mission avoid");
  } else if (base.scenario.targets.size() < 2 || flight->marks.size() < 2) {
    mistakes.Add(a.scenario, "targets", "fewer than two, or fewer than two marks",
                 "valid: two of either, for what they look like");
  } else if (base.scenario.autopilot.speed_limit_m_s < 5) {
    mistakes.Add(
        a.scenario, "autopilot.speed_limit_m_s",
        fmt::format("{:g}, and encounters are flown at up to 5 m/s", base.scenario.autopilot.speed_limit_m_s),
        "valid: from 5");
  }
  CheckWritableFolder(a.out, "--out", mistakes);
  CheckWritableFile(a.json, "--json", mistakes);
  // All that the flights depend on, and not the file's name, whose content may change.
  settings = fmt::format("# {}\n", Version());
  for (const auto& [name, value] : sim::ThisMachine()) settings += fmt::format("# {} {}\n", name, value);
  settings += ToYaml(base.scenario);
  const fs::path file = fs::path(a.out) / "settings.txt";
  if (IsFile(file) && ReadFile(file) != settings)
    mistakes.Add(
        "--out", "",
        fmt::format("{} holds encounters of other settings, another version or another machine or --isa",
                    a.out),
        "valid: another folder, or that one removed");
  mistakes.ThrowIfAny();
  return base;
}

}  // namespace

CLI::App* AddEncountersCommand(CLI::App& app, EncountersArguments& a) {
  CLI::App* command =
      app.add_subcommand("encounters", "Random meetings in the air, with avoidance and without");
  command->add_option("scenario", a.scenario, "Of the mission avoid: its camera, gains, marks and weather")
      ->type_name("SCENARIO")
      ->capture_default_str();
  command->add_option("--count", a.count, "Near encounters, each flown twice")
      ->check(WholeNumber(0, 100000))
      ->capture_default_str();
  command->add_option("--harmless", a.harmless, "Harmless encounters, in which nothing should be done")
      ->check(WholeNumber(0, 100000))
      ->capture_default_str();
  command->add_option("--seed", a.seed, "Of the first encounter; the next ones follow")
      ->capture_default_str();
  command->add_option("--jobs", a.jobs, "Flights at the same time")
      ->check(WholeNumber(1, 256))
      ->capture_default_str();
  command->add_option("--set", a.overrides, "key.path=value, as for run")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option("--out", a.out,
                   "Folder of encounters.csv and encounters.png; a set that was broken off goes on there")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_flag("--record", a.record,
                    "Write video, telemetry and plots of every flight with avoidance to DIR/SEED");
  command->add_option("--json", a.json, "Also write the figures as JSON to this file")->type_name("FILE");
  command->footer(
      "Examples:\n"
      "  kestrel encounters avoid --count 400\n"
      "  kestrel encounters avoid --seed 17 --count 1 --harmless 0 --record --out results/runs/seventeen\n"
      "  kestrel encounters avoid --count 50 --harmless 0 --set flight.avoidance.safe_m=3 --out "
      "results/runs/wide");
  return command;
}

bool EncountersCommand(const EncountersArguments& a) {
  std::string settings;
  const flight::LoadedScenario base = Load(a, settings);
  const fs::path folder = a.out, file = folder / "encounters.csv";
  const WriterLock alone = LockFolder(folder);
  WriteFile(folder / "settings.txt", settings);

  auto outcomes = ReadOutcomes(file);
  std::vector<std::pair<bool, std::uint64_t>> wanted, missing;
  for (int i = 0; i < a.count; ++i) wanted.emplace_back(false, a.seed + static_cast<std::uint64_t>(i));
  for (int i = 0; i < a.harmless; ++i)
    wanted.emplace_back(true, kHarmlessSeeds + a.seed + static_cast<std::uint64_t>(i));
  for (const auto& key : wanted)
    if (!outcomes.contains(key)) missing.push_back(key);
  if (missing.size() < wanted.size())
    fmt::print("{} of {} encounters are flown already\n", wanted.size() - missing.size(), wanted.size());
  const auto write_all = [&] {
    std::string text = kRowHeader;
    for (const auto& [key, outcome] : outcomes) text += LineOf(outcome);
    WriteFile(file, text);
  };
  write_all();  // without a line that was cut off

  std::mutex mutex;
  std::ofstream rows(file, std::ios::app | std::ios::binary);
  InParallel(missing.size(), a.jobs, "encounters", "flown", [&](std::size_t i) {
    const auto& [harmless, seed] = missing[i];
    flight::RunOptions options;
    if (a.record) options.folder = folder / fmt::format("{}", seed);
    const Outcome outcome = Meet(base, harmless, seed, options);
    const std::lock_guard lock(mutex);
    rows << LineOf(outcome) << std::flush;
    if (!rows) throw std::runtime_error(fmt::format("cannot write {}", file.string()));
    outcomes[outcome.Key()] = outcome;
  });
  rows.close();
  write_all();

  std::vector<Outcome> asked;
  std::vector<double> without, with;
  for (const auto& key : wanted) {
    asked.push_back(outcomes.at(key));
    if (key.first) continue;
    without.push_back(asked.back().closest_without_m), with.push_back(asked.back().closest_m);
  }
  const double radius_m = base.scenario.flight.As<scenarios::AvoidFlight>()->avoidance.safe_m / 2;
  const std::vector<records::Figure> table = TableOf(asked, radius_m);
  records::PrintFigures(table);
  if (!a.json.empty()) records::WriteFigures(a.json, table);
  if (!with.empty()) {
    if (std::none_of(without.begin(), without.end(), [&](double m) { return m < radius_m; }))
      fmt::print("None came nearer than R without avoidance: there is no risk ratio.\n");
    Draw(folder / "encounters.png", without, with, radius_m);
  }
  fmt::print("Each encounter{}: {}\n", with.empty() ? "" : " and the picture", folder.string());
  return records::AllMet(table);
}

}  // namespace kestrel::app
