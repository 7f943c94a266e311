// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel check`: whether a scenario and the models that it names can be flown.
struct CheckArguments {
  std::string file;
  std::vector<std::string> overrides;
};

CLI::App* AddCheckCommand(CLI::App& app, CheckArguments& arguments);

// Throws InputError with every mistake.
void CheckCommand(const CheckArguments& arguments);

}  // namespace kestrel::app
