// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/option/live_option.h"

namespace kestrel::app {

struct FlyArguments {
  std::string scenario, autopilot, aircraft, out;
  std::vector<std::string> cameras;  // one, or two: on board and on the ground
  std::vector<std::string> overrides, aircraft_overrides;
  std::optional<double> for_s, wait_s;
  LiveArguments live;
  bool dry_run = false, take_control = false, arm = false, pilot_untold = false;
  bool no_video = false, images = false;
};

CLI::App* AddFlyCommand(CLI::App& app, FlyArguments& arguments);

// Goes through the check list, and flies. True: the flight did what it is for. Throws InputError with every
// mistake, before anything is opened.
bool FlyCommand(const FlyArguments& arguments);

}  // namespace kestrel::app
