// SPDX-License-Identifier: Apache-2.0
// The program `kestrel-fly`, for real aircraft: what needs no simulator.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "app/camera/calibrate_command.h"
#include "app/flight/export_command.h"
#include "app/flight/fly_command.h"
#include "app/flight/replay_command.h"
#include "app/manual/manual_command.h"
#include "app/option/exit_status.h"
#include "app/option/program.h"
#include "app/page/report_command.h"
#include "base/diagnostics.h"
#include "flight/flight_plan.h"
#include "flight/hardware/fly.h"

namespace kestrel::app {
namespace {

int Main(int argc, char** argv) {
  Program program(
      "kestrel-fly",
      "Kestrel for real aircraft: flight by vision.\n\nExit status: 0 the flight did what it is for, "
      "1 it did not, 2 bad input, 3 it broke off.");
  CLI::App& app = program.command_line();
  const auto met = [](bool is) { return is ? kMet : kNotMet; };
  FlyArguments fly;
  program.Add(AddFlyCommand(app, fly), [&] { return met(FlyCommand(fly)); });
  ReplayArguments replay;
  program.Add(AddReplayCommand(app, replay), [&] { return met(ReplayCommand(replay)); });
  ReportArguments report;
  program.Add(AddReportCommand(app, report), [&] { return ReportCommand(report), kMet; });
  ExportArguments to_export;
  program.Add(AddExportCommand(app, to_export), [&] { return ExportCommand(to_export), kMet; });
  CalibrateArguments calibrate;
  program.Add(AddCalibrateCommand(app, calibrate), [&] { return CalibrateCommand(calibrate), kMet; });
  std::string check_file;
  std::vector<std::string> check_overrides;
  CLI::App* check = app.add_subcommand("check", "Validate a scenario as a flight of a real aircraft");
  check->add_option("file", check_file, "A scenario's name, or a YAML file")->required();
  check->add_option("--set", check_overrides, "key.path=value, as for fly");
  program.Add(check, [&] {
    const flight::LoadedPlan plan = flight::LoadPlan(check_file, check_overrides);
    Mistakes mistakes;
    flight::CheckDeclared(*plan.plan.flight->Make(plan.parts), plan.plan.mission, mistakes);
    mistakes.ThrowIfAny();
    fmt::print("{} is valid\n", check_file);
    return kMet;
  });
  ManualArguments manual;
  program.Add(AddCompletionCommand(app, manual), [&] { return CompletionCommand(app, manual), kMet; });
  program.Add(AddManCommand(app), [&] { return ManCommand(app), kMet; });
  program.TakePlugins({"fly", "check", "replay", "export"});
  app.footer(
      "Examples:\n  kestrel-fly fly hover --camera v4l2:/dev/video0 --autopilot mavlink:udpin://:14540 "
      "--dry-run\n"
      "  kestrel-fly replay results/runs/hover-flown-20250101-120000");
  return program.Run(argc, argv);
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
