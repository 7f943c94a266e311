// SPDX-License-Identifier: Apache-2.0
// The command line of the build for real aircraft: what needs no simulator.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "app/camera/calibrate_command.h"
#include "app/flight/fly_command.h"
#include "app/flight/replay_command.h"
#include "app/manual/manual_command.h"
#include "app/option/exit_status.h"
#include "app/option/parse_command_line.h"
#include "app/option/plugin_option.h"
#include "base/diagnostics.h"
#include "base/printable.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "flight/flight_plan.h"
#include "flight/load_plugins.h"

namespace kestrel::app {
namespace {

int Main(int argc, char** argv) {
  cv::setNumThreads(1);
  CLI::App app{
      "Kestrel for real aircraft: flight by vision.\n\nExit status: 0 the flight did what it is for, "
      "1 it did not, 2 bad input, 3 it broke off.",
      "kestrel"};
  app.require_subcommand(1);
  app.set_version_flag("--version", Version());
  FlyArguments fly;
  const CLI::App* fly_command = AddFlyCommand(app, fly);
  ReplayArguments replay;
  const CLI::App* replay_command = AddReplayCommand(app, replay);
  CalibrateArguments calibrate;
  const CLI::App* calibrate_command = AddCalibrateCommand(app, calibrate);
  std::string check_file;
  std::vector<std::string> check_overrides;
  CLI::App* check_command = app.add_subcommand("check", "Validate a scenario as a flight of a real aircraft");
  check_command->add_option("file", check_file, "A scenario's name, or a YAML file")->required();
  check_command->add_option("--set", check_overrides, "key.path=value, as for fly");
  ManualArguments manual;
  const CLI::App* completion_command = AddCompletionCommand(app, manual);
  const CLI::App* man_command = AddManCommand(app);
  std::vector<std::string> plugins;
  for (const char* name : {"fly", "check", "replay"}) AddPluginOption(app.get_subcommand(name), plugins);
  app.footer(
      "Examples:\n  kestrel fly hover --camera v4l2:/dev/video0 --autopilot mavlink:udpin://:14540 "
      "--dry-run\n"
      "  kestrel replay results/runs/hover-flown-20250101-120000");
  if (const auto status = ParseCommandLine(app, argc, argv)) return *status;
  try {
    flight::LoadPlugins(plugins);
    if (*fly_command) return FlyCommand(fly) ? kMet : kNotMet;
    if (*replay_command) return ReplayCommand(replay) ? kMet : kNotMet;
    if (*calibrate_command) {
      CalibrateCommand(calibrate);
      return kMet;
    }
    if (*completion_command) {
      CompletionCommand(app, manual);
      return kMet;
    }
    if (*man_command) {
      ManCommand(app);
      return kMet;
    }
    if (*check_command) {
      flight::LoadPlan(check_file, check_overrides);
      fmt::print("{} is valid\n", check_file);
      return kMet;
    }
  } catch (const InputError& e) {
    PrintNote("{}\n", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    PrintNote("kestrel: {}\n", Printable(e.what()));
    return kBrokeOff;
  }
  return kBadInput;
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
