// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel encounters`: random meetings in the air, each flown twice from the same seed, with avoidance and
// without; and harmless ones, in which nothing should be done.
struct EncountersArguments {
  std::string scenario = "avoid";  // everything but who flies where and how fast
  int count = 400, harmless = 400;
  std::uint64_t seed = 1;
  int jobs = 2;
  std::vector<std::string> overrides;
  std::string out = "results/runs/encounters", json;
  bool record = false;  // every flight with avoidance, as `kestrel run` does
};

CLI::App* AddEncountersCommand(CLI::App& app, EncountersArguments& arguments);

// Flies them, a line of encounters.csv each, and prints the table; whether all its targets were met. What the
// folder already holds of the same encounters is not flown again. Throws InputError with every mistake, also
// if the folder holds encounters of other settings.
bool EncountersCommand(const EncountersArguments& arguments);

}  // namespace kestrel::app
