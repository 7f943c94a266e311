// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"
#include "campaign/execution/scenario_files.h"
#include "campaign/execution/worker_pool.h"
#include "campaign/tuning/tune_plan.h"

namespace kestrel::campaign {

// In a tuning's folder.
std::filesystem::path FlightsFile(const std::filesystem::path& folder);

// What it is of: a row for each flight that it can come to; what each flies with is
// known only then.
CampaignIdentity FlightsOf(const LoadedTune& tune);

// Flights that several searches want: a flight depends on its overrides alone, so one is flown once.
using SharedFlights = std::map<std::vector<std::string>, RunResult>;

// A tuning's Fly: what is kept in the folder, or known, is not flown again, and what is flown is kept there.
class FlightCache {
 public:
  // known: of tunings by the same scenario and set, and of this one then. stopped: when it comes true, or a
  // file that the flights are read from changes, a call throws std::runtime_error. Throws InputError: the
  // folder holds another tuning.
  FlightCache(const LoadedTune& tune, const std::filesystem::path& folder, int jobs,
              std::vector<std::string> worker, const std::atomic<bool>& stopped, SharedFlights& known);

  std::vector<RunResult> operator()(const std::vector<RunOrder>& orders);
  std::size_t cached() const { return kept_.size(); }
  std::vector<RunResult> Rows(std::int64_t from, std::int64_t to) const;  // from, ..., to - 1, counted from 0

 private:
  RunResult Store(RunResult result, const RunOrder& order);

  ResultStore store_;
  ScenarioFiles files_;
  int jobs_;
  double limit_s_;
  std::filesystem::path logs_;
  std::vector<std::string> worker_;
  const std::atomic<bool>& stopped_;
  SharedFlights& known_;
  std::map<std::int64_t, RunResult> kept_;
  std::optional<WorkerPool> pool_;
};

}  // namespace kestrel::campaign
