// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel reproduce`: the thesis's tables and figures, flown, drawn and set beside the thesis's numbers.
struct ReproduceArguments {
  std::vector<std::string> names;  // none: all
  bool list = false;
  std::uint64_t seed = 1;
  int jobs = 2;
  std::string out = "results/runs/reproduce";
};

CLI::App* AddReproduceCommand(CLI::App& app, ReproduceArguments& arguments);

// Whether every flight was flown to its end and every picture drawn. Throws InputError with every mistake.
bool ReproduceCommand(const ReproduceArguments& arguments);

}  // namespace kestrel::app
