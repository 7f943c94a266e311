// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/option/live_option.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel run`: flies a scenario in the simulator, and records it.
struct RunArguments {
  std::string scenario, out, junit;
  std::vector<std::string> overrides;
  std::string seed, mcap, view, view_size;
  LiveArguments live;
  bool no_video = false, images = false, truth = false, events = false, quiet = false;
};

CLI::App* AddRunCommand(CLI::App& app, RunArguments& arguments);

// The exit status. Throws InputError; std::runtime_error: it cannot even begin.
int RunCommand(const RunArguments& arguments);

// What is valid in a scenario and may yet surprise, a line each.
void PrintNotes(const std::vector<std::string>& notes);

}  // namespace kestrel::app
