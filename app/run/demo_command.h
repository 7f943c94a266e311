// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "app/option/live_option.h"

namespace CLI {
class App;
}

namespace kestrel::app {

struct DemoArguments {
  LiveArguments live;
  std::string out;
};

CLI::App* AddDemoCommand(CLI::App& app, DemoArguments& arguments);

// Flies one flight of each kind, one after the other, for whoever opens the address that it prints; begins with the
// first viewer. The exit status. Throws InputError with every mistake.
int DemoCommand(const DemoArguments& arguments);

}  // namespace kestrel::app
