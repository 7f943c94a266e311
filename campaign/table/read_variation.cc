// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/read_variation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/nearest_name.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/table/given_once.h"
#include "campaign/table/sampling.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using Kind = ConfigNode::Kind;
using List = std::vector<std::string>;

// As YAML on one line.
std::string FlowText(const ConfigNode& node) {
  List parts;
  switch (node.kind) {
    case Kind::kNothing:
      return "null";
    case Kind::kText: {
      const bool plain =
          !node.text.empty() && node.text.find_first_of("\"\\'#,:[]{}&*!|>%@` \n\t") == std::string::npos;
      if (!node.quoted && plain) return node.text;
      std::string quoted = "\"";
      for (const char c : node.text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c == '\n' ? std::string("\\n") : std::string(1, c);
      }
      return quoted + '"';
    }
    case Kind::kList:
      for (const auto& [index, member] : node.members) parts.push_back(FlowText(member));
      return fmt::format("[{}]", fmt::join(parts, ", "));
    case Kind::kMap:
      for (const auto& [key, member] : node.members)
        parts.push_back(fmt::format("{}: {}", key, FlowText(member)));
      return fmt::format("{{{}}}", fmt::join(parts, ", "));
  }
  return "";
}

struct DistributionKind {
  const char* name;
  const char* arguments;
};
constexpr DistributionKind kKinds[] = {{"uniform", "[low, high]"},
                                       {"log_uniform", "[low, high]"},
                                       {"normal", "[mean, standard deviation]"},
                                       {"truncated_normal", "[mean, standard deviation, low, high]"},
                                       {"choice", "a list of values"},
                                       {"grid", "a list of values"}};

List KindNames() {
  List names;
  for (const DistributionKind& kind : kKinds) names.push_back(kind.name);
  return names;
}

// A list of numbers.
std::optional<std::vector<double>> NumbersOf(const ConfigNode& node, std::size_t count) {
  if (node.kind != Kind::kList || node.members.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const auto& [index, member] : node.members) {
    Mistakes none;
    double number = 0;
    const ConfigNode holder{Kind::kMap, "", false, "", {{"n", member}}};
    FieldReader(holder, "", none)("n", number, -1e300, 1e300);
    if (!none.empty()) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

std::optional<Distribution> ReadDistribution(const ConfigNode& node, const std::string& path,
                                             Mistakes& mistakes) {
  const auto wrong = [&](const std::string& what, const std::string& remedy = "") {
    mistakes.Add(node.where, path, what, remedy);
    return std::nullopt;
  };
  if (node.kind != Kind::kMap || node.members.size() != 1)
    return wrong(fmt::format("{} is not a distribution", node.kind == Kind::kMap
                                                             ? fmt::format("a map of {}", node.members.size())
                                                             : FlowText(node)),
                 fmt::format("valid: one of {}, as in {{uniform: [0, 6]}}", fmt::join(KindNames(), ", ")));
  const auto& [name, value] = node.members.front();
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                 [&name = name](const auto& k) { return name == k.name; });
  if (kind == std::end(kKinds)) {
    const auto near = NearestName(name, KindNames());
    return wrong(fmt::format("there is no distribution '{}'", name),
                 fmt::format("{}valid: {}", near ? fmt::format("did you mean '{}'? ", *near) : "",
                             fmt::join(KindNames(), ", ")));
  }
  if (name == "choice" || name == "grid") {
    if (value.kind != Kind::kList || value.members.empty())
      return wrong(fmt::format("the {} is {}", name, value.kind == Kind::kList ? "empty" : FlowText(value)),
                   "valid: a list of one value or more");
    List values;
    std::set<std::string> different;
    for (const auto& [index, member] : value.members) {
      values.push_back(FlowText(member));
      if (!different.insert(values.back()).second && name == "grid")
        return wrong(fmt::format("the grid has {} twice", values.back()));
    }
    if (name == "choice") return Choice{values};
    return Grid{values};
  }
  const auto n = NumbersOf(value, name == "truncated_normal" ? 4 : 2);
  if (!n)
    return wrong(fmt::format("{}: {} is not valid", name, FlowText(value)),
                 fmt::format("valid: {}", kind->arguments));
  if (name == "normal" || name == "truncated_normal") {
    if ((*n)[1] <= 0) return wrong(fmt::format("the standard deviation is {}", (*n)[1]), "valid: above 0");
    if (name == "normal") return Normal{(*n)[0], (*n)[1]};
  }
  const double low = n->end()[-2], high = n->end()[-1];
  if (low >= high) return wrong(fmt::format("low = {} is not below high = {}", low, high));
  if (name == "log_uniform" && low <= 0)
    return wrong(fmt::format("low = {} has no logarithm", low), "valid: above 0");
  if (name == "uniform") return Uniform{low, high};
  if (name == "log_uniform") return LogUniform{low, high};
  // Ten deviations from the mean nothing is left to be cut.
  if (low > (*n)[0] + 10 * (*n)[1] || high < (*n)[0] - 10 * (*n)[1])
    return wrong(
        fmt::format("from {} to {} there is nothing of a normal of mean {} and standard deviation {}", low,
                    high, (*n)[0], (*n)[1]));
  return TruncatedNormal{(*n)[0], (*n)[1], low, high};
}

void ReadVary(const ConfigNode& node, const std::string& prefix, std::map<std::string, Distribution>& vary,
              std::map<std::string, Place>& places, Mistakes& mistakes) {
  for (const auto& [name, member] : node.members) {
    const std::string key = prefix.empty() ? name : prefix + '.' + name;
    const bool deeper = member.kind == Kind::kMap && !member.members.empty() &&
                        std::all_of(member.members.begin(), member.members.end(),
                                    [](const auto& m) { return m.node.kind == Kind::kMap; });
    if (deeper) {
      ReadVary(member, key, vary, places, mistakes);
      continue;
    }
    const auto place = places.find(key);
    if (place != places.end() && !IsOverride(member.where))
      mistakes.Add(member.where, "vary." + key, "given twice, first at " + place->second.Text());
    places[key] = member.where;
    if (const auto distribution = ReadDistribution(member, "vary." + key, mistakes))
      vary.insert_or_assign(key, *distribution);
  }
}

// What the scenario says of what it is set to, by the file or by the command line.
void RefuseScenario(const Diagnostic& wrong, const ConfigNode& root, const CampaignPlan& plan,
                    Mistakes& mistakes) {
  const auto set = std::find_if(plan.set.rbegin(), plan.set.rend(), [&](const std::string& each) {
    return wrong.place() == PlaceOfOverride(each);
  });
  Diagnostic reported = wrong;
  reported.remedy.clear();
  if (set == plan.set.rend())
    return mistakes.Add(WhereIn(root, {"scenario"}), "scenario", reported.Text(), wrong.remedy);
  for (const auto& [name, node] : root.members) {
    for (const auto& [index, member] : node.members) {
      if (name != "set" || member.text != *set) continue;
      reported.file = *set;
      return mistakes.Add(member.where, "set", reported.Text(), wrong.remedy);
    }
  }
  mistakes.Add(wrong);
}

void RefuseConstant(const std::string& key, const CampaignPlan& plan, const Place& where,
                    const std::string& path, Mistakes& mistakes) {
  if (IsReported(mistakes, "vary." + key)) return;  // it does, in a way that is not valid
  List names;
  for (const auto& [name, distribution] : plan.vary) names.push_back(name);
  mistakes.Add(where, path, fmt::format("'{}' does not vary", key), RemedyForName(key, names));
}

void CheckGroups(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes) {
  std::map<std::string, std::size_t> group_of;
  for (std::size_t g = 0; g < plan.correlated.size(); ++g) {
    const CorrelatedGroup& group = plan.correlated[g];
    const std::string index = std::to_string(g), path = "correlated." + index;
    const Place& where = WhereIn(root, {"correlated", index, "keys"});
    if (group.keys.size() < 2)
      mistakes.Add(where, path + ".keys", fmt::format("a group of {}", group.keys.size()),
                   "valid: two keys or more");
    for (const std::string& key : group.keys) {
      const auto vary = plan.vary.find(key);
      if (vary == plan.vary.end()) {
        RefuseConstant(key, plan, where, path + ".keys", mistakes);
      } else if (std::holds_alternative<Grid>(vary->second) || std::holds_alternative<Choice>(vary->second)) {
        mistakes.Add(where, path + ".keys",
                     fmt::format("'{}' is a {}, which has no ranks", key,
                                 std::holds_alternative<Grid>(vary->second) ? "grid" : "choice"),
                     "valid: uniform, log_uniform, normal, truncated_normal");
      }
      if (const auto [other, first] = group_of.try_emplace(key, g); !first)
        mistakes.Add(where, path + ".keys",
                     other->second == g ? fmt::format("'{}' is named twice", key)
                                        : fmt::format("'{}' is in correlated.{} already", key, other->second),
                     "valid: in one group");
    }
    const double min = MinRankCorrelation(std::max<int>(2, static_cast<int>(group.keys.size())));
    if (group.rank_correlation <= min + 1e-9 || group.rank_correlation >= 1 - 1e-9)
      mistakes.Add(WhereIn(root, {"correlated", index, "rank_correlation"}), path + ".rank_correlation",
                   fmt::format("{} each with each is no correlation that {} keys can have",
                               group.rank_correlation, group.keys.size()),
                   fmt::format("valid: above {:.4g} and below 1", min));
  }
}

void CheckSame(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes) {
  std::set<std::string> taken;
  for (std::size_t i = 0; i < plan.same.size(); ++i) {
    const auto& [key, as] = plan.same[i];
    const std::string index = std::to_string(i), path = "same." + index;
    const Place& where = WhereIn(root, {"same", index, "key"});
    if (plan.vary.count(key))
      mistakes.Add(where, path + ".key", fmt::format("'{}' varies for itself", key), "valid: one of the two");
    if (!taken.insert(key).second)
      mistakes.Add(where, path + ".key", fmt::format("'{}' is given twice", key));
    if (key == "seed")
      mistakes.Add(where, path + ".key", "each run has a seed of its own",
                   "valid: another key, or vary.seed");
    if (!plan.vary.count(as))
      RefuseConstant(as, plan, WhereIn(root, {"same", index, "as"}), path + ".as", mistakes);
  }
}

bool IsList(const Distribution& distribution) {
  return std::holds_alternative<Choice>(distribution) || std::holds_alternative<Grid>(distribution);
}

// Of a long list of numbers its minimum, its maximum, and one that is not whole if there is any; of another
// list all.
List ValuesOfList(List values) {
  constexpr std::size_t kLong = 100;  // to load a scenario with each takes long
  if (values.size() <= kLong) return values;
  std::optional<std::string> broken;
  std::pair<double, std::size_t> min{HUGE_VAL, 0}, max{-HUGE_VAL, 0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const char* last = values[i].data() + values[i].size();
    double number = 0;
    const auto end = std::from_chars(values[i].data(), last, number);
    if (end.ptr != last || end.ec != std::errc{}) return values;
    min = std::min(min, {number, i});
    max = std::max(max, {number, i});
    if (number != std::floor(number)) broken = values[i];
  }
  List tried{values[min.second], values[max.second]};
  if (broken) tried.push_back(*broken);
  return tried;
}

// Those of a key that the scenario must take. Both ends may be whole where what is between them is not.
List ValuesToTry(const Distribution& distribution) {
  if (IsList(distribution)) return ValuesOfList(Extremes(distribution));
  List values = Extremes(distribution);
  values.push_back(ValueAt(distribution, 0.3819660113));
  return values;
}

struct KeyToTry {
  std::string key;
  const Distribution& distribution;
  Place where;
  std::string path;
};

void TryKey(const KeyToTry& k, const List& chosen, const CampaignPlan& plan, Mistakes& mistakes) {
  const List values = ValuesToTry(k.distribution);
  const std::size_t ends = IsList(k.distribution) ? values.size() : 2;
  bool all = true;
  for (std::size_t i = 0; i < values.size() && (i < ends || all); ++i) {
    const std::string_view remedy = i >= ends ? "of whole numbers valid: choice or grid"
                                    : std::holds_alternative<Normal>(k.distribution)
                                        ? "a normal reaches 10 deviations off: valid: truncated_normal"
                                        : "";
    if (CheckOverride(plan, chosen, k.key, values[i], k.where, k.path, remedy, mistakes)) continue;
    all = false;
    if (mistakes.all().back().what == kUnknownKey) return;  // reported once
  }
}

void TryKeys(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes) {
  std::vector<KeyToTry> keys;
  for (const auto& [key, distribution] : plan.vary)
    keys.push_back({key, distribution, WhereIn(root, {"vary", key}), "vary." + key});
  for (std::size_t i = 0; i < plan.same.size(); ++i) {
    const std::string index = std::to_string(i);
    if (const auto as = plan.vary.find(plan.same[i].as); as != plan.vary.end())
      keys.push_back({plan.same[i].key, as->second, WhereIn(root, {"same", index, "key"}),
                      fmt::format("same.{}.key", index)});
  }
  // To load a scenario takes long, so first all at once, each in turn at one of its values.
  std::vector<List> together;
  for (const KeyToTry& k : keys) {
    const List values = ValuesToTry(k.distribution);
    if (values.size() > together.size()) together.resize(values.size());
  }
  for (std::size_t i = 0; i < together.size(); ++i) {
    for (const KeyToTry& k : keys) {
      const List values = ValuesToTry(k.distribution);
      together[i].push_back(fmt::format("{}={}", k.key, values[i % values.size()]));
    }
  }
  if (TakesAll(plan, together)) return;
  // A key may have no meaning but with a choice made: a landscape's light, in a world that is one.
  List chosen;
  for (const KeyToTry& k : keys)
    if (IsList(k.distribution))
      chosen.push_back(fmt::format("{}={}", k.key, Extremes(k.distribution).front()));
  for (const KeyToTry& k : keys) TryKey(k, chosen, plan, mistakes);
}

}  // namespace

const Place& WhereIn(const ConfigNode& root, std::initializer_list<std::string_view> path) {
  const ConfigNode* node = &root;
  for (const std::string_view part : path) {
    const auto found = std::find_if(node->members.rbegin(), node->members.rend(),
                                    [&](const auto& member) { return member.key == part; });
    if (found == node->members.rend()) break;
    node = &found->node;
  }
  return node->where;
}

bool IsReported(const Mistakes& mistakes, const std::string& key) {
  return std::any_of(mistakes.all().begin(), mistakes.all().end(), [&](const Diagnostic& each) {
    return each.key == key || each.key.starts_with(key + '.');
  });
}

SplitOverrides Split(const List& overrides, const List& keys) {
  List of_scenario = KeysOf<flight::Scenario>();
  of_scenario.push_back("gains");
  SplitOverrides split;
  for (const std::string& each : overrides) {
    const std::string first = each.substr(0, each.find_first_of(".="));
    const auto has = [&](const List& list) {
      return std::find(list.begin(), list.end(), first) != list.end();
    };
    const bool of_file =
        has(keys) || each.find('=') == std::string::npos || (!has(of_scenario) && NearestName(first, keys));
    (of_file ? split.of_file : split.of_scenario).push_back(each);
  }
  return split;
}

void SetInstead(const List& overrides, List& set) {
  for (const std::string& each : overrides) {
    const std::string key = each.substr(0, each.find('='));
    std::erase_if(set, [&](const std::string& s) { return s.starts_with(key + '.'); });
    const auto same =
        std::find_if(set.begin(), set.end(), [&](const std::string& s) { return s.starts_with(key + '='); });
    if (same == set.end())
      set.push_back(each);
    else
      *same = each;
  }
}

std::map<std::string, Distribution> ReadVary(const ConfigNode& vary, Mistakes& mistakes) {
  std::map<std::string, Distribution> read;
  std::map<std::string, Place> places;
  if (vary.kind == Kind::kMap)
    ReadVary(vary, "", read, places, mistakes);
  else if (vary.kind != Kind::kNothing)
    mistakes.Add(vary.where, "vary",
                 fmt::format("{} is not a map of keys and distributions", FlowText(vary)));
  return read;
}

bool CheckOverride(const CampaignPlan& plan, const List& others, const std::string& key,
                   const std::string& value, const Place& where, const std::string& path,
                   std::string_view remedy, Mistakes& mistakes) {
  const std::string text = fmt::format("{}={}", key, value);
  const auto complaint = [&](List overrides) -> std::optional<Diagnostic> {
    overrides.push_back(text);
    try {
      flight::LoadScenario(plan.scenario, overrides);
      return std::nullopt;
    } catch (const InputError& e) {
      return e.diagnostics.front();
    }
  };
  const auto refused = complaint(plan.set);
  if (!refused) return true;
  if (!others.empty()) {
    List overrides = plan.set;
    overrides.insert(overrides.end(), others.begin(), others.end());
    if (!complaint(overrides)) return true;
  }
  // The place and the key are those of this file.
  Diagnostic rest = *refused;
  if (rest.place() == PlaceOfOverride(text)) rest.file.clear();
  if (rest.file.empty() && rest.key == key) rest.key.clear();
  std::string remedies = std::move(rest.remedy);
  rest.remedy.clear();
  const std::string what = rest.Text();
  const bool unknown = what == kUnknownKey;
  if (!unknown && !remedy.empty()) remedies += fmt::format("{}{}", remedies.empty() ? "" : "; ", remedy);
  // Such as "3 is out of range" says the value itself.
  const bool reported = unknown || what.starts_with(value) || what.starts_with('\'' + value);
  mistakes.Add(where, path, reported ? what : fmt::format("with {}: {}", value, what), remedies);
  return false;
}

bool TakesAll(const CampaignPlan& plan, const std::vector<List>& sets) {
  for (const List& each : sets) {
    List overrides = plan.set;
    overrides.insert(overrides.end(), each.begin(), each.end());
    try {
      flight::LoadScenario(plan.scenario, overrides);
    } catch (const InputError&) {
      return false;
    }
  }
  return true;
}

bool ResolveVariation(const fs::path& file, const ConfigNode& root, CampaignPlan& plan, Mistakes& mistakes) {
  if (plan.name.empty()) plan.name = file.stem().string();
  if (!NamesFolder(plan.name))
    mistakes.Add(WhereIn(root, {"name"}), "name", fmt::format("'{}' cannot name a folder", plan.name),
                 "valid: no slash, no leading dot, no control character");
  double points = 1;
  for (const auto& [key, distribution] : plan.vary)
    if (const auto* grid = std::get_if<Grid>(&distribution))
      points *= static_cast<double>(grid->values.size());
  const bool too_long = points * plan.runs > kMaxRows;
  if (too_long)
    mistakes.Add(WhereIn(root, {"runs"}), "runs",
                 fmt::format("{} at each of the {:.0f} points of the grids are {:.0f} runs", plan.runs,
                             points, points * plan.runs),
                 fmt::format("valid: no more than {}", kMaxRows));
  if (plan.vary.size() > 3667)
    mistakes.Add(WhereIn(root, {"vary"}), "vary", fmt::format("{} keys", plan.vary.size()),
                 "valid: no more than 3667");
  const auto refuse_set = [&](const std::string& key, const Place& where, const std::string& path) {
    for (const std::string& each : plan.set) {
      const std::string set = each.substr(0, each.find('='));
      if (set == key || set.starts_with(key + '.'))
        mistakes.Add(where, path, fmt::format("'{}' varies, and set has '{}'", key, each),
                     "valid: one of the two");
    }
  };
  for (const auto& [key, distribution] : plan.vary)
    refuse_set(key, WhereIn(root, {"vary", key}), "vary." + key);
  for (std::size_t i = 0; i < plan.same.size(); ++i) {
    const std::string index = std::to_string(i);
    refuse_set(plan.same[i].key, WhereIn(root, {"same", index, "key"}), fmt::format("same.{}.key", index));
  }
  CheckGroups(root, plan, mistakes);
  CheckSame(root, plan, mistakes);
  CheckGivenOnce(root, plan, mistakes);
  if (plan.scenario.empty()) return false;  // reported already
  const List names = ScenarioNames();
  const fs::path beside = file.parent_path() / plan.scenario;
  const Place& where = WhereIn(root, {"scenario"});
  if (std::find(names.begin(), names.end(), plan.scenario) == names.end()) {
    if (!IsFile(beside)) {
      mistakes.Add(where, "scenario",
                   fmt::format("there is no scenario '{}', nor a file '{}'", plan.scenario, beside.string()),
                   RemedyForName(plan.scenario, names));
      return false;
    }
    plan.scenario = fs::absolute(beside).lexically_normal().string();
  }
  try {
    flight::LoadScenario(plan.scenario, plan.set);
  } catch (const InputError& e) {
    for (const Diagnostic& each : e.diagnostics) RefuseScenario(each, root, plan, mistakes);
    return false;
  }
  if (!too_long) TryKeys(root, plan, mistakes);
  return true;
}

}  // namespace kestrel::campaign
