// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/metric_aims.h"

#include <fmt/format.h>

#include <set>

#include "base/yaml/config.h"
#include "campaign/table/campaign_plan.h"

namespace kestrel::campaign {
namespace {

using Kind = ConfigNode::Kind;

// With the overrides that are noted below it.
ConfigNode Parsed(const std::string& yaml, const std::string& name) {
  Mistakes mistakes;
  Config config = ParseConfig(yaml, name, OverridesNotedIn(yaml), mistakes);
  mistakes.ThrowIfAny();
  return std::move(config.root);
}

const ConfigNode* Member(const ConfigNode& node, const std::string& key) {
  for (const auto& [name, member] : node.members)
    if (name == key) return &member;
  return nullptr;
}

void Flatten(const ConfigNode& node, const std::string& path, std::map<std::string, std::string>& values) {
  if (node.members.empty()) {
    if (!path.empty()) values[path] = node.kind == Kind::kNothing ? "null" : node.text;
    return;
  }
  for (const auto& [name, member] : node.members)
    Flatten(member, path.empty() ? name : path + '.' + name, values);
}

}  // namespace

std::map<std::string, std::string> ValuesOf(const std::string& yaml, const std::string& name) {
  std::map<std::string, std::string> values;
  Flatten(Parsed(yaml, name), "", values);
  return values;
}

MetricAims AimsOf(const CampaignIdentity& identity) {
  MetricAims aims;
  const ConfigNode scenario = Parsed(identity.scenario, "scenario"), plan = Parsed(identity.plan, "plan");
  const ConfigNode* metrics = Member(plan, "metrics");
  if (metrics)
    for (const auto& [index, metric] : metrics->members) aims.listed.push_back(metric.text);
  for (const ConfigNode* limits : {Member(plan, "thresholds"), Member(scenario, "criteria")}) {
    if (!limits) continue;
    for (const auto& [name, limit] : limits->members) {
      const auto given = [&limit = limit](const char* key) {
        const ConfigNode* value = Member(limit, key);
        return value && value->kind == Kind::kText && value->text != "null" && value->text != "~";
      };
      if (given("max") != given("min"))
        aims.better.emplace(name, given("max") ? Better::kLower : Better::kHigher);
    }
  }
  if (aims.listed.empty())
    if (const ConfigNode* criteria = Member(scenario, "criteria"))
      for (const auto& [name, limit] : criteria->members) aims.listed.push_back(name);
  return aims;
}

}  // namespace kestrel::campaign
