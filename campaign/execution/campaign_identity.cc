// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/campaign_identity.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace kestrel::campaign {
namespace {

// The first line in which two texts differ, as "line 3 is 'a', and not 'b'".
std::string FirstDifference(const std::string& has, const std::string& wanted) {
  std::istringstream a(has), b(wanted);
  for (int line = 1;; ++line) {
    std::string one, other;
    const bool more = static_cast<bool>(std::getline(a, one));
    const bool others = static_cast<bool>(std::getline(b, other));
    if (!more && !others) return "their ends of lines differ";
    if (!more) return fmt::format("line {}, '{}', is not in it", line, other);
    if (!others) return fmt::format("line {} is '{}', and should not be there", line, one);
    if (one != other) return fmt::format("line {} is '{}', and not '{}'", line, one, other);
  }
}

// The options below a plan's file, as they are typed; the text becomes the file's alone.
std::vector<std::string> TakeOptions(std::string& plan) {
  constexpr std::string_view kNoted = "\n# --";
  std::vector<std::string> options;
  while (plan.ends_with('\n')) {
    const std::size_t at = plan.rfind(kNoted);
    if (at == std::string::npos || plan.find('\n', at + 1) != plan.size() - 1) break;
    std::string option = plan.substr(at + 3, plan.size() - 1 - (at + 3));
    for (const std::string key : {"runs", "seed"})
      if (const std::string set = "--set " + key + "="; option.starts_with(set))
        option = fmt::format("--{} {}", key, option.substr(set.size()));
    options.insert(options.begin(), option);
    plan.resize(at);
  }
  return options;
}

// Those of a that b has not.
std::vector<std::string> Without(std::vector<std::string> a, const std::vector<std::string>& b) {
  std::erase_if(a, [&](const auto& each) { return std::find(b.begin(), b.end(), each) != b.end(); });
  return a;
}

std::vector<std::string> PlanDifferences(std::string has, std::string wanted) {
  const auto had = TakeOptions(has), now = TakeOptions(wanted);
  std::vector<std::string> differences;
  if (has != wanted) differences.push_back("it is of another, whose " + FirstDifference(has, wanted));
  if (had == now) return differences;
  auto gone = Without(had, now), come = Without(now, had);
  if (gone.empty() && come.empty()) gone = had, come = now;  // in another order
  differences.push_back(
      come.empty()   ? fmt::format("flown with {}, now without", fmt::join(gone, " "))
      : gone.empty() ? fmt::format("flown without {}, now with it", fmt::join(come, " "))
                     : fmt::format("flown with {}, now with {}", fmt::join(gone, " "), fmt::join(come, " ")));
  return differences;
}

// The line by which a campaign ends before its table does, and other options that come after a plan's text.
bool SameRule(std::string has, std::string wanted) {
  const auto rule = [](std::string& plan) {
    std::vector<std::string> options = TakeOptions(plan);
    std::erase_if(options, [](const std::string& each) { return each.starts_with("--set "); });
    return options;
  };
  return rule(has) == rule(wanted);
}

std::string FirstDifference(const SampleTable& has, const SampleTable& wanted) {
  if (has.keys != wanted.keys)
    return fmt::format("it varies {}, and not {}", nlohmann::json(has.keys).dump(),
                       nlohmann::json(wanted.keys).dump());
  if (has.rows.size() != wanted.rows.size())
    return fmt::format("it is of {} rows, and not {}", has.rows.size(), wanted.rows.size());
  for (std::size_t r = 0; r < has.rows.size(); ++r)
    for (std::size_t k = 0; k < has.keys.size(); ++k)
      if (has.rows[r][k] != wanted.rows[r][k])
        return fmt::format("row {}: {} is {}, and not {}", r, has.keys[k], has.rows[r][k], wanted.rows[r][k]);
  return {};
}

std::string OtherMachine(const sim::Machine& has, const sim::Machine& wanted) {
  std::vector<std::string> all;
  for (const auto& [name, values] : sim::MachineDifferences(has, wanted))
    all.push_back(fmt::format("{} {} and not {}", name, values.first, values.second));
  return fmt::format(
      "{}: by that its last bits are others (where processors differ, the same --isa from the first flight "
      "on makes "
      "them alike; where libraries do, the same packages)",
      fmt::join(all, ", "));
}

}  // namespace

std::vector<std::string> ModelsThatDiffer(const std::string& has, const std::string& wanted) {
  const auto lines = [](const std::string& text) {
    std::vector<std::string> all;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  };
  std::set<std::string> names;
  for (const auto& [one, other] : {std::pair(has, wanted), std::pair(wanted, has)})
    for (const std::string& line : Without(lines(one), lines(other)))
      names.insert(line.substr(0, line.rfind(' ')));
  return {names.begin(), names.end()};
}

std::vector<std::string> Differences(const CampaignIdentity& has, const CampaignIdentity& wanted,
                                     bool same_table) {
  std::vector<std::string> differences;
  if (has.name != wanted.name)
    differences.push_back(fmt::format("name: it is of '{}', and not of '{}'", has.name, wanted.name));
  if (has.version != wanted.version)
    differences.push_back(
        fmt::format("version: it is of {}, and this program is {}", has.version, wanted.version));
  if (has.machine.empty() != wanted.machine.empty())
    differences.push_back("machine: what it was flown on is not known");
  else if (has.machine != wanted.machine)
    differences.push_back("machine: it was flown on another, with " +
                          OtherMachine(has.machine, wanted.machine));
  const std::string table = FirstDifference(has.table, wanted.table);
  const bool same_flights = !has.tuning && !wanted.tuning && has.scenario == wanted.scenario &&
                            table.empty() && same_table && has.limit_s == wanted.limit_s &&
                            SameRule(has.plan, wanted.plan);
  if (!same_flights)
    for (const std::string& each : PlanDifferences(has.plan, wanted.plan))
      differences.push_back("plan: " + each);
  if (has.tuning != wanted.tuning)
    differences.push_back(fmt::format("kind: it is of a {}", has.tuning ? "tuning" : "campaign"));
  if (const auto models = ModelsThatDiffer(has.models, wanted.models); !models.empty())
    differences.push_back(fmt::format("models: it was flown with another {}", fmt::join(models, ", ")));
  if (has.scenario != wanted.scenario)
    differences.push_back("scenario: it is of another, whose " +
                          FirstDifference(has.scenario, wanted.scenario));
  if (!table.empty()) differences.push_back("table: it is of another: " + table);
  return differences;
}

}  // namespace kestrel::campaign
