// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/flight_cache.h"

#include <set>
#include <stdexcept>
#include <utility>

#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {

std::filesystem::path FlightsFile(const std::filesystem::path& folder) { return folder / "flights.sqlite"; }

CampaignIdentity FlightsOf(const LoadedTune& tune) {
  SampleTable table{{"flight"}, {}};
  const std::size_t most = static_cast<std::size_t>(tune.plan.budget) + 3 * tune.held_out.rows.size();
  for (std::size_t i = 0; i < most; ++i) table.rows.push_back({std::to_string(i)});
  const CampaignPlan& flights = tune.plan.flights;
  CampaignIdentity identity{flights.name,
                            ToYaml(flight::LoadScenario(flights.scenario, flights.set).scenario), tune.text,
                            Version(), table};
  identity.models = ScenarioFiles(flights.scenario, flights.set, tune.held_out.keys).Models();
  identity.limit_s = flights.limit_s;
  identity.machine = sim::ThisMachine();
  identity.tuning = true;
  return identity;
}

FlightCache::FlightCache(const LoadedTune& tune, const std::filesystem::path& folder, int jobs,
                         std::vector<std::string> worker, const std::atomic<bool>& stopped,
                         SharedFlights& known)
    : store_(ResultStore::Open(FlightsFile(folder), FlightsOf(tune))),
      files_(tune.plan.flights.scenario, tune.plan.flights.set, tune.held_out.keys),
      jobs_(jobs),
      limit_s_(tune.plan.flights.limit_s),
      logs_(folder / "logs"),
      worker_(std::move(worker)),
      stopped_(stopped),
      known_(known) {
  for (RunResult& result : store_.Results()) {
    const std::int64_t row = result.row;
    kept_.emplace(row, std::move(result));
  }
}

std::vector<RunResult> FlightCache::operator()(const std::vector<RunOrder>& orders) {
  std::vector<RunResult> results;
  std::map<std::int64_t, const RunOrder*> missing;
  std::set<std::vector<std::string>> wanted;
  std::vector<const RunOrder*> alike;  // as one that is kept, known or wanted already
  for (const RunOrder& order : orders) {
    if (const auto kept = kept_.find(order.row); kept != kept_.end()) {
      known_.emplace(order.overrides, kept->second);
      results.push_back(kept->second);
    } else if (known_.contains(order.overrides) || !wanted.insert(order.overrides).second) {
      alike.push_back(&order);
    } else {
      missing.emplace(order.row, &order);
    }
  }
  if (!missing.empty() && !pool_) pool_.emplace(jobs_, limit_s_, logs_, worker_);
  for (auto next = missing.begin(); next != missing.end() || (pool_ && pool_->under_way() > 0);) {
    if (stopped_) throw std::runtime_error("interrupted; the same command goes on from here");
    for (; next != missing.end() && pool_->Idle(); ++next) {
      files_.RequireUnchanged();
      pool_->Give(*next->second);
    }
    if (auto result = pool_->WaitForResult(0.2)) {
      const RunOrder& order = *missing.at(result->row);
      results.push_back(Store(std::move(*result), order));
    }
  }
  for (const RunOrder* order : alike) {
    RunResult result = known_.at(order->overrides);
    result.row = order->row;
    results.push_back(Store(std::move(result), *order));
  }
  return results;
}

std::vector<RunResult> FlightCache::Rows(std::int64_t from, std::int64_t to) const {
  std::vector<RunResult> results;
  for (auto kept = kept_.lower_bound(from); kept != kept_.end() && kept->first < to; ++kept) {
    results.push_back(kept->second);
    results.back().row -= from;
  }
  return results;
}

RunResult FlightCache::Store(RunResult result, const RunOrder& order) {
  store_.Put(result);
  kept_.emplace(result.row, result);
  known_.emplace(order.overrides, result);
  return result;
}

}  // namespace kestrel::campaign
