// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/possible_metrics.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "records/telemetry/metrics.h"
#include "scenarios/flights.h"

namespace kestrel::flight {
namespace {

// "fix_*" is of all that begin with it.
bool Matches(std::string_view pattern, std::string_view name) {
  return pattern.ends_with('*') ? name.starts_with(pattern.substr(0, pattern.size() - 1)) : pattern == name;
}

// What metrics were called in earlier versions, and are called now.
constexpr std::pair<const char*, const char*> kFormerMetrics[] = {{"greatest_tilt_deg", "max_tilt_deg"}};

void Rename(std::string& name, const Place& where) {
  for (const auto& [former, now] : kFormerMetrics) {
    if (name != former) continue;
    NoticeFormerName(where, former, now);
    name = now;
  }
}

}  // namespace

std::vector<std::string> KnownMetrics() {
  scenarios::AddFlights();
  return NamesOf(records::AllMetrics());
}

void RenameFormerMetrics(Config& config, const std::vector<std::string>& keys) {
  for (auto& [key, node] : config.root.members) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) continue;
    for (auto& [name, member] : node.members)
      Rename(node.kind == ConfigNode::Kind::kList ? member.text : name, member.where);
  }
}

std::vector<std::string> PossibleMetrics(const Scenario& s,
                                         const std::function<bool(const std::string& key)>& varies) {
  const mission::MissionType& type = s.flight.type();
  const bool attitude_fails = !s.sensors.attitude_faults.empty() || varies("sensors.attitude_faults");
  const auto declared = [&](const std::string& name) {
    return std::any_of(type.common_metrics.begin(), type.common_metrics.end(),
                       [&](const std::string& pattern) { return Matches(pattern, name); });
  };
  const auto changes = [&](const std::string& key) { return varies(key); };
  std::vector<std::string> names;
  for (const auto& [name, unit, description, low, high] : records::CommonMetrics()) {
    const bool of_every_flight = name == "fix_share" || name == "max_tilt_deg";
    const bool of_a_failure = name.starts_with("failure_") && attitude_fails;
    if (of_every_flight || of_a_failure || declared(name)) names.push_back(name);
  }
  const bool others_matter = !s.targets.empty();
  for (const auto& [name, unit, description, low, high] : type.metrics)
    if (s.flight->CanHave(name, [&](const std::string& key) {
          return changes(key) || (key == "targets" && others_matter);
        }))
      names.push_back(name);
  return names;
}

}  // namespace kestrel::flight
