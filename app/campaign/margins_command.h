// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel margins`: how far the gains of a scenario are from swinging with its autopilot.
struct MarginsArguments {
  std::string file;
  std::vector<std::string> overrides;
};

CLI::App* AddMarginsCommand(CLI::App& app, MarginsArguments& arguments);

// Prints them; false: one is less than the least. Throws InputError.
bool MarginsCommand(const MarginsArguments& arguments);

}  // namespace kestrel::app
