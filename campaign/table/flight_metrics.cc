// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/flight_metrics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/nearest_name.h"
#include "flight/simulated/possible_metrics.h"
#include "records/telemetry/metrics.h"

namespace kestrel::campaign {
namespace {

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// A key, something in it, or what it is in.
bool Varies(const CampaignPlan& plan, const std::string& key) {
  const auto touches = [&](const std::string& other) {
    return other == key || other.starts_with(key + '.') || key.starts_with(other + '.');
  };
  return std::any_of(plan.vary.begin(), plan.vary.end(), [&](const auto& v) { return touches(v.first); }) ||
         std::any_of(plan.same.begin(), plan.same.end(), [&](const SameValue& s) { return touches(s.key); });
}

}  // namespace

FlightMetrics::FlightMetrics(const CampaignPlan& plan) : own_(flight::KnownMetrics()) {
  if (plan.scenario.empty() || Varies(plan, "mission")) return;
  try {
    const flight::Scenario scenario = flight::LoadScenario(plan.scenario, plan.set, false).scenario;
    own_ = flight::PossibleMetrics(scenario, [&](const std::string& key) { return Varies(plan, key); });
    mission_ = scenario.mission;
  } catch (const InputError&) {}  // said elsewhere
}

void FlightMetrics::Check(const std::string& metric, const std::vector<std::string>& also, const Place& where,
                          const std::string& path, Mistakes& mistakes) {
  std::vector<std::string> valid = own_;
  valid.insert(valid.end(), also.begin(), also.end());
  if (Has(valid, metric)) return;
  const bool anothers = Has(flight::KnownMetrics(), metric);
  const std::string what =
      anothers ? fmt::format("a flight of this scenario, of the mission '{}', has no '{}'", mission_, metric)
               : fmt::format("there is no metric '{}'", metric);
  const auto near = anothers ? std::nullopt : NearestName(metric, valid);
  if (near) return mistakes.Add(where, path, what, fmt::format("did you mean '{}'?", *near));
  mistakes.Add(where, path, what,
               all_reported_ ? "valid: as said above" : fmt::format("valid: {}", fmt::join(valid, ", ")));
  all_reported_ = true;
}

}  // namespace kestrel::campaign
