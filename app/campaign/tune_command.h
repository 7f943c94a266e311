// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "campaign/execution/worker_pool.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel tune`: looks for the gains of lowest cost.
struct TuneArguments {
  std::string file, out;
  std::vector<std::string> overrides;
  int compare = 0;  // searches by each method, side by side; 0: one, by the file's
  int jobs = 0;     // 0: one for each core
  bool quiet = false;
  std::vector<std::string> worker = campaign::WorkerCommand();
};

CLI::App* AddTuneCommand(CLI::App& app, TuneArguments& arguments);

// Flies, and writes gains.yaml, tuning.json and report.html; to compare, the first two for each search into a
// folder METHOD-SEED. Whether the gains found, by the first search, were shown to be better than those it
// began with. What the folder already holds of the same tuning is not flown again. Throws InputError with
// every mistake, also if the folder holds another tuning; std::runtime_error if it was interrupted.
bool TuneCommand(const TuneArguments& arguments);

}  // namespace kestrel::app
