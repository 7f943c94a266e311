// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel {

// `kestrel tune`: looks for the gains of least cost.
struct TuneArguments {
  std::string file, out;
  std::vector<std::string> overrides;
  int jobs = 0;  // 0: one for each core
  bool quiet = false;
  std::vector<std::string> worker = {"/proc/self/exe", "campaign-worker"};  // its command
};

CLI::App* AddTuneCommand(CLI::App& app, TuneArguments& arguments);

// Flies, and writes gains.yaml and tuning.json; whether the gains found were shown to be better than those it
// began with. What the folder already holds of the same tuning is not flown again. Throws InputError with
// every mistake, also if the folder holds another tuning; std::runtime_error if it was interrupted.
bool TuneCommand(const TuneArguments& arguments);

}  // namespace kestrel
