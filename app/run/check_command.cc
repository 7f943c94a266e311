// SPDX-License-Identifier: Apache-2.0
#include "app/run/check_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/run/run_command.h"
#include "flight/simulated/scenario.h"

namespace kestrel::app {

CLI::App* AddCheckCommand(CLI::App& app, CheckArguments& a) {
  CLI::App* command = app.add_subcommand("check", "Validate a scenario and its models without flying it");
  command->add_option("file", a.file, "A name that `list` shows, or a YAML file")
      ->type_name("SCENARIO")
      ->required();
  command->add_option("--set", a.overrides, "key.path=value, as for run")->type_name("KEY=VALUE");
  command->footer("Examples:\n  kestrel check my_flight.yaml --set camera=fisheye");
  return command;
}

void CheckCommand(const CheckArguments& a) {
  const flight::LoadedScenario loaded = flight::LoadScenario(a.file, a.overrides);
  fmt::print("{} is valid\n", a.file);
  PrintNotes(loaded.notes);
  if (!loaded.pad_heights.empty()) PrintNotes({loaded.pad_heights});
}

}  // namespace kestrel::app
