// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/changes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "base/yaml/describe_fields.h"
#include "base/yaml/yaml_fields.h"
#include "base/yaml/yaml_nodes.h"
#include "flight/simulated/check/check_image.h"

namespace kestrel::flight {
namespace {

constexpr double kRounding_s = 1e-9;

// What of a scenario the simulator changes in flight, and how.
struct OfWorld {
  const char* pattern;  // of keys
  void (*change)(const Scenario& scenario, sim::Simulator& simulator);
};
constexpr auto kWind = [](const Scenario& s, sim::Simulator& simulator) { simulator.Change(s.wind); };
constexpr auto kLight = [](const Scenario& s, sim::Simulator& simulator) {
  simulator.ChangeDaylight(s.render.daylight);
};
constexpr auto kTargets = [](const Scenario& s, sim::Simulator& simulator) { simulator.Change(s.targets); };
constexpr auto kCamera = [](const Scenario& s, sim::Simulator& simulator) {
  simulator.Change(s.image.faults);
};
constexpr auto kSensors = [](const Scenario& s, sim::Simulator& simulator) {
  simulator.Change(s.sensors.faults, s.sensors.attitude_faults);
};
constexpr auto kActuators = [](const Scenario& s, sim::Simulator& simulator) {
  simulator.Change(s.actuators);
};
constexpr OfWorld kWorld[] = {{"wind.mean_m_s", kWind},
                              {"wind.from_deg", kWind},
                              {"wind.turbulence", kWind},
                              {"wind.gusts.*", kWind},
                              {"render.daylight", kLight},
                              {"targets.*.velocity_m_s*", kTargets},
                              {"targets.*.roam_m_s", kTargets},
                              {"targets.*.roam_within_m", kTargets},
                              {"image.faults*", kCamera},
                              {"sensors.faults*", kSensors},
                              {"sensors.attitude_faults*", kSensors},
                              {"actuators.faults*", kActuators}};

bool Covers(const std::string& pattern, const std::string& key) {
  return fnmatch(pattern.c_str(), key.c_str(), 0) == 0;
}

const OfWorld* InWorld(const std::string& key) {
  const auto found = std::ranges::find_if(kWorld, [&](const OfWorld& w) { return Covers(w.pattern, key); });
  return found != std::end(kWorld) ? found : nullptr;
}

bool InMission(const Scenario& s, const std::string& key) {
  return std::ranges::any_of(s.flight.type().changeable,
                             [&](const std::string& pattern) { return Covers(pattern, key); });
}

std::vector<std::string> AllPatterns(const Scenario& s) {
  std::vector<std::string> all;
  for (const OfWorld& each : kWorld) all.emplace_back(each.pattern);
  const std::vector<std::string>& own = s.flight.type().changeable;
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

std::optional<FieldDescription> Describe(Scenario scenario, const std::string& key) {
  return DescribeAt([&](FieldVisitor& v) { Fields(v, scenario); }, key);
}

ConfigNode Parsed(const std::string& yaml, Mistakes& mistakes) {
  return ParseConfig(yaml, "value", {}, mistakes).root;
}

std::string Flow(const std::string& yaml) {
  Mistakes none;
  return FlowText(Parsed(yaml, none));
}

// A map's keys have no order.
bool Same(const ConfigNode& a, const ConfigNode& b) {
  if (a.kind != b.kind || a.text != b.text || a.members.size() != b.members.size()) return false;
  return std::ranges::all_of(a.members, [&](const ConfigNode::Member& each) {
    const auto other = std::ranges::find(b.members, each.key, &ConfigNode::Member::key);
    return other != b.members.end() && Same(each.node, other->node);
  });
}

void Numbers(const ConfigNode& node, std::vector<double>& all) {
  if (node.kind == ConfigNode::Kind::kText) all.push_back(std::strtod(node.text.c_str(), nullptr));
  for (const auto& [key, member] : node.members) Numbers(member, all);
}

const ChangeableKeys* Declared(const Scenario& s, const std::string& key) {
  const auto found = std::ranges::find(s.changeable, key, &ChangeableKeys::key);
  return found != s.changeable.end() ? &*found : nullptr;
}

std::vector<std::string> KeysOf(const Scenario& s) {
  std::vector<std::string> keys;
  for (const ChangeableKeys& each : s.changeable) keys.push_back(each.key);
  return keys;
}

struct Range {
  double low = 0, high = 0;
};
// Within that of its key.
Range RangeOf(const ChangeableKeys& declared, const FieldDescription& field) {
  return {declared.min.value_or(field.low.value_or(-1e9)), declared.max.value_or(field.high.value_or(1e9))};
}

// What the scenario itself says of a value that its key may have.
void CheckDeclared(const ChangeableKeys& declared, const Scenario& changed, const ConfigNode& value,
                   Mistakes& mistakes) {
  Mistakes none;
  std::vector<std::string> choices;
  for (const std::string& choice : declared.choices) choices.push_back(Flow(choice));
  if (!choices.empty() && std::ranges::none_of(declared.choices, [&](const std::string& choice) {
        return Same(Parsed(choice, none), value);
      }))
    mistakes.Add("", declared.key, FlowText(value) + " is not offered by changeable",
                 fmt::format("valid: {}", fmt::join(choices, ", or ")));
  if (!declared.min && !declared.max) return;
  const auto field = Describe(changed, declared.key);
  std::vector<double> numbers;
  if (!field) return;
  Numbers(Parsed(field->value, none), numbers);
  const auto [low, high] = RangeOf(declared, *field);
  if (std::ranges::any_of(numbers, [&](double n) { return n < low || n > high; }))
    mistakes.Add("", declared.key, FlowText(value) + " is out of the range that changeable gives it",
                 fmt::format("valid: {} to {}", low, high));
}

// The remedy for a value that its key does not take, with what the scenario leaves of the key's range.
std::string Narrowed(std::string remedy, const ChangeableKeys& declared, const Scenario& s) {
  const auto field = Describe(s, declared.key);
  if (!field || !field->low || !field->high) return remedy;
  const auto [low, high] = RangeOf(declared, *field);
  const std::string of_key = fmt::format("{} to {}", *field->low, *field->high);
  if (const std::size_t at = remedy.find(of_key); at != std::string::npos)
    remedy.replace(at, of_key.size(), fmt::format("{} to {}", low, high));
  return remedy;
}

// The scenario with another value of a key; what is wrong with it is among the mistakes.
Scenario Changed(const LoadedScenario& loaded, const Scenario& scenario, const std::string& key,
                 const ConfigNode& value, Mistakes& mistakes) {
  const ChangeableKeys* declared = Declared(scenario, key);
  if (!declared) {
    mistakes.Add("", key, "is not among what this scenario lets change in flight",
                 scenario.changeable.empty() ? "valid: none, as it has no `changeable`"
                                             : fmt::format("valid: {}", fmt::join(KeysOf(scenario), ", ")));
    return scenario;
  }
  Scenario changed = scenario;
  Mistakes own;
  const std::string text = FlowText(value);
  Read(ParseConfig(ToYaml(scenario), "scenario", {key + '=' + text}, own), changed, own);
  if (own.empty()) {
    CheckNumbers(changed, loaded.simulator.vehicle, {}, "", own);
    CheckImage(changed.image, &loaded.simulator.camera, "", own);
    CheckDeclared(*declared, changed, value, own);
  }
  for (const Diagnostic& each : own.all())
    mistakes.Add("", each.key, each.what, Narrowed(each.remedy, *declared, scenario));
  return changed;
}

// In one sentence.
std::string Sentence(const Mistakes& mistakes) {
  std::vector<std::string> all;
  for (const Diagnostic& each : mistakes.all()) {
    std::string text = each.key.empty() ? each.what : each.key + ": " + each.what;
    if (!each.remedy.empty()) text += "; " + each.remedy;
    all.push_back(std::move(text));
  }
  return fmt::format("{}", fmt::join(all, "; "));
}

Place WhereOfItem(const Config& config, const char* list, std::size_t index, const Place& file) {
  const ConfigNode* node = Find(config, list);
  if (!node) return file;
  return index < node->members.size() ? node->members[index].node.where : node->where;
}

void CheckChangeable(const Scenario& s, const Config& config, const Place& file, Mistakes& mistakes) {
  for (std::size_t i = 0; i < s.changeable.size(); ++i) {
    const ChangeableKeys& each = s.changeable[i];
    const Place where = WhereOfItem(config, "changeable", i, file);
    const std::string name = fmt::format("changeable.{}", i);
    const auto field = Describe(s, each.key);
    if (!field && Covers("targets.*", each.key) && InWorld(each.key))
      continue;  // with fewer of them, not that one
    if (!field || !(InWorld(each.key) || InMission(s, each.key))) {
      mistakes.Add(where, name + ".key",
                   fmt::format("{}'{}'{}", field ? "" : "this scenario has no key ", each.key,
                               field ? " cannot be changed in flight" : ""),
                   fmt::format("valid: {}", fmt::join(AllPatterns(s), ", ")));
      continue;
    }
    if (Declared(s, each.key) != &each)
      mistakes.Add(where, name + ".key", fmt::format("'{}' is given twice", each.key), "valid: once");
    const auto limit = [&](const char* which, const std::optional<double>& value) {
      if (value && !field->low)
        mistakes.Add(where, fmt::format("{}.{}", name, which), fmt::format("'{}' is no number", each.key),
                     "valid: null");
      else if (value && (*value < *field->low || *value > *field->high))
        mistakes.Add(where, fmt::format("{}.{}", name, which),
                     fmt::format("{:g} is out of the range of {}", *value, each.key),
                     fmt::format("valid: {:g} to {:g}", *field->low, *field->high));
    };
    limit("min", each.min);
    limit("max", each.max);
    if (each.min && each.max && *each.min > *each.max)
      mistakes.Add(where, name + ".min", fmt::format("{:g} is above max = {:g}", *each.min, *each.max),
                   "valid: no more than that");
  }
}

}  // namespace

void CheckChanges(const LoadedScenario& loaded, Scenario& scenario, const Config& config, const Place& file,
                  Mistakes& mistakes) {
  Mistakes own;
  CheckChangeable(scenario, config, file, own);
  std::vector<std::size_t> order(scenario.changes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const std::vector<ChangeKeys> as_written = scenario.changes;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return as_written[i].at_s; });
  Scenario now = scenario;
  scenario.changes.clear();
  for (const std::size_t i : order) {
    scenario.changes.push_back(as_written[i]);
    if (!own.empty()) continue;
    Mistakes of_change;
    now = Changed(loaded, now, as_written[i].key, as_written[i].value, of_change);
    const bool known = Declared(scenario, as_written[i].key);
    if (!of_change.empty())
      own.Add(WhereOfItem(config, "changes", i, file),
              fmt::format("changes.{}.{}", i, known ? "value" : "key"), Sentence(of_change));
  }
  for (const Diagnostic& each : own.all()) mistakes.Add(each);
}

Changes::Changes(const LoadedScenario& loaded, sim::Simulator& simulator, mission::Mission* mission,
                 std::function<void(const MadeChange&)> told)
    : loaded_(loaded),
      simulator_(simulator),
      mission_(mission),
      told_(std::move(told)),
      flown_(loaded.scenario),
      now_(loaded.scenario) {}

void Changes::FlyBy(mission::Mission* mission) {
  mission_ = mission;
  if (mission_) mission_->Change(now_.flight, now_.pilot);
}

void Changes::MakeDue() {
  for (; next_ < flown_.changes.size() && flown_.changes[next_].at_s <= simulator_.truth().t_s + kRounding_s;
       ++next_) {
    const ChangeKeys& change = flown_.changes[next_];
    Mistakes none;  // they were looked for when it was loaded, and before each change by hand
    Apply(change, Changed(loaded_, now_, change.key, change.value, none), false);
  }
}

std::string Changes::Make(const std::string& key, const std::string& value) {
  MakeDue();
  Mistakes mistakes;
  const ChangeKeys change{simulator_.truth().t_s, key, Parsed(value, mistakes)};
  if (!mistakes.empty()) return key + ": " + Sentence(mistakes);
  const Scenario changed = Changed(loaded_, now_, key, change.value, mistakes);
  if (!mistakes.empty()) return Sentence(mistakes);
  if (!InWorld(key) && !mission_) return key + ": nobody flies by the scenario's own mission here";
  Scenario later = changed;
  for (std::size_t i = next_; i < flown_.changes.size(); ++i) {
    const ChangeKeys& planned = flown_.changes[i];
    later = Changed(loaded_, later, planned.key, planned.value, mistakes);
    if (!mistakes.empty())
      return fmt::format("{}: the scenario's own change at {:g} s could not be made then: {}", key,
                         planned.at_s, Sentence(mistakes));
  }
  flown_.changes.insert(flown_.changes.begin() + static_cast<std::ptrdiff_t>(next_++), change);
  Apply(change, changed, true);
  return "";
}

void Changes::Apply(const ChangeKeys& change, const Scenario& changed, bool by_hand) {
  const auto begun = Describe(now_, change.key);
  const std::string before = std::exchange(
      told_values_.try_emplace(change.key, begun ? begun->value : "").first->second, FlowText(change.value));
  now_ = changed;
  if (const OfWorld* world = InWorld(change.key))
    world->change(now_, simulator_);
  else if (mission_)
    mission_->Change(now_.flight, now_.pilot);
  if (told_) told_({simulator_.truth().t_s, change.key, before, told_values_[change.key], by_hand});
}

std::vector<records::ChangeableKey> Changes::All() const {
  std::vector<records::ChangeableKey> all;
  for (const ChangeableKeys& declared : now_.changeable) {
    if (!InWorld(declared.key) && !mission_) continue;
    const auto field = Describe(now_, declared.key);
    if (!field) continue;  // an element of a list that is shorter now
    records::ChangeableKey each{declared.key, field->meaning, field->value, declared.min, declared.max, {}};
    if (!each.min) each.min = field->low;
    if (!each.max) each.max = field->high;
    for (const std::string& choice : declared.choices) each.choices.push_back(Flow(choice));
    if (each.choices.empty() && field->kind == FieldKind::kFlag) each.choices = {"true", "false"};
    if (each.choices.empty())
      for (const std::string& valid : field->valid) each.choices.push_back('"' + valid + '"');
    all.push_back(std::move(each));
  }
  return all;
}

}  // namespace kestrel::flight
