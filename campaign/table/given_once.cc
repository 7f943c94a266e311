// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/given_once.h"

#include <fmt/format.h>

#include <map>
#include <set>

#include "base/diagnostics.h"
#include "campaign/table/read_variation.h"

namespace kestrel::campaign {

void CheckGivenOnce(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes) {
  std::map<std::string, std::string> set;  // by key
  for (std::size_t i = 0; i < plan.set.size(); ++i) {
    const std::string key = plan.set[i].substr(0, plan.set[i].find('=')), index = std::to_string(i);
    const auto [first, is_new] = set.emplace(key, plan.set[i]);
    if (!is_new)
      mistakes.Add(WhereIn(root, {"set", index}), "set." + index,
                   fmt::format("'{}': '{}' is given twice, first as '{}'", plan.set[i], key, first->second),
                   "valid: once");
  }

  std::map<std::string, const char*> varies;  // each key, and in which list
  for (const auto& [key, distribution] : plan.vary) varies[key] = "vary";
  for (const SameValue& same : plan.same) varies[same.key] = "same";
  for (const auto& [key, list] : varies)
    for (std::size_t dot = key.find('.'); dot != key.npos; dot = key.find('.', dot + 1))
      if (const std::string whole = key.substr(0, dot); varies.contains(whole))
        mistakes.Add(WhereIn(root, {list, key}), fmt::format("{}.{}", list, key),
                     fmt::format("is a part of '{}', which varies too", whole), "valid: one of the two");

  std::set<std::string> metrics;
  for (std::size_t i = 0; i < plan.metrics.size(); ++i)
    if (const std::string index = std::to_string(i); !metrics.insert(plan.metrics[i]).second)
      mistakes.Add(WhereIn(root, {"metrics", index}), "metrics." + index,
                   fmt::format("'{}' is given twice", plan.metrics[i]), "valid: once");
}

}  // namespace kestrel::campaign
