// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace kestrel::app {

struct ReplayArguments {
  std::string folder, video;
  std::vector<std::string> overrides;
  double tolerance = 0;
  bool quiet = false;
};

CLI::App* AddReplayCommand(CLI::App& app, ReplayArguments& arguments);

// Gives the images and states of a recorded flight to its mission again, and tells where what is measured and
// asked for now differs from what it was then. True: nowhere by more than the tolerance.
bool ReplayCommand(const ReplayArguments& arguments);

}  // namespace kestrel::app
