// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>

#include "base/nearest_name.h"
#include "control/law/fuzzy/fuzzy_rule.h"

namespace kestrel::control {
namespace {

using Variables = std::map<std::string, FuzzyVariable>;

template <class T>
std::vector<std::string> NamesOf(const std::map<std::string, T>& all) {
  std::vector<std::string> names;
  for (const auto& [name, each] : all) names.push_back(name);
  return names;
}

// A place in the range of an input, and the sets in which it is.
struct Situation {
  double x;
  std::set<std::string> sets;
};

// Those of an input in which the fewest sets hold: a rule that fires in them fires everywhere. Memberships are
// straight between corners, so corners and the middles between them show all.
std::vector<Situation> BarestSituations(const FuzzyVariable& variable) {
  std::vector<double> places = {variable.low, variable.high};
  for (const auto& [name, set] : variable.sets)
    for (const double corner : set.corners)
      if (variable.low < corner && corner < variable.high) places.push_back(corner);
  std::sort(places.begin(), places.end());
  for (std::size_t i = places.size() - 1; i > 0; --i) places.push_back((places[i - 1] + places[i]) / 2);
  std::vector<Situation> barest;
  for (const double x : places) {
    Situation here{x, {}};
    for (const auto& [name, set] : variable.sets)
      if (Membership(set, x) > 0) here.sets.insert(name);
    const auto within = [](const Situation& a, const Situation& b) {
      return std::includes(b.sets.begin(), b.sets.end(), a.sets.begin(), a.sets.end());
    };
    if (std::any_of(barest.begin(), barest.end(), [&](const auto& other) { return within(other, here); }))
      continue;
    std::erase_if(barest, [&](const auto& other) { return within(here, other); });
    barest.push_back(std::move(here));
  }
  return barest;
}

class ControllerCheck {
 public:
  ControllerCheck(const FuzzyController& controller, const std::string& key, const Place& where,
                  Mistakes& mistakes)
      : controller_(controller), key_(key), where_(where), mistakes_(mistakes) {}

  void All() {
    CheckVariables(controller_.inputs, "inputs", true);
    CheckVariables(controller_.outputs, "outputs", false);
    if (controller_.rules.empty())
      Wrong("rules", "there is no rule", "valid: at least one, as 'if error is high then descent is fast'");
    for (std::size_t i = 0; i < controller_.rules.size(); ++i)
      CheckRule(controller_.rules[i], fmt::format("rules.{}", i));
    if (sound_) CheckThatRulesSuffice();
  }

 private:
  void Wrong(std::string_view key, std::string_view what, std::string_view remedy) {
    mistakes_.Add(where_, fmt::format("{}.{}", key_, key), what, remedy);
    sound_ = false;
  }

  void CheckName(const std::string& name, const std::string& key) {
    if (!IsFuzzyName(name))
      Wrong(key, fmt::format("'{}' is no name that a rule can have", name),
            "valid: a single word other than if, is, and, then");
  }

  void CheckVariables(const Variables& variables, const std::string& kind, bool inputs) {
    if (variables.empty()) Wrong(kind, "there is none", "valid: at least one variable");
    for (const auto& [name, variable] : variables) {
      const std::string key = fmt::format("{}.{}", kind, name);
      CheckName(name, key);
      if (inputs && controller_.outputs.contains(name))
        Wrong(key, fmt::format("'{}' is an output too", name), "valid: a name of its own");
      CheckVariable(variable, key, inputs);
    }
  }

  void CheckVariable(const FuzzyVariable& variable, const std::string& key, bool input) {
    const bool ascends = variable.low < variable.high;
    if (!ascends)
      Wrong(key + ".low", fmt::format("{:g} is not below high = {:g}", variable.low, variable.high),
            "valid: less than that");
    if (variable.sets.empty()) return Wrong(key + ".sets", "there is none", "valid: at least one set");
    bool in_order = true;
    for (const auto& [name, set] : variable.sets) {
      const std::string key_of_set = fmt::format("{}.sets.{}", key, name);
      CheckName(name, key_of_set);
      const Eigen::Vector4d& at = set.corners;
      if (!std::is_sorted(at.begin(), at.end())) {
        in_order = false;
        Wrong(key_of_set + ".corners",
              fmt::format("[{:g}, {:g}, {:g}, {:g}] are out of order", at[0], at[1], at[2], at[3]),
              "valid: each at least as great as the one before");
      } else if (!input && ascends && !(std::max(at[0], variable.low) < std::min(at[3], variable.high))) {
        Wrong(key_of_set + ".corners", "the set has no part of the range",
              fmt::format("valid: a set that covers some of {:g} to {:g}", variable.low, variable.high));
      }
    }
    if (!input || !ascends || !in_order) return;
    for (const Situation& situation : BarestSituations(variable))
      if (situation.sets.empty())
        Wrong(key + ".sets", fmt::format("no set covers {:g}", situation.x),
              fmt::format("valid: sets that cover all from {:g} to {:g}", variable.low, variable.high));
  }

  void CheckRule(const std::string& text, const std::string& key) {
    const ParsedRule parsed = ParseRule(text);
    if (!parsed.rule)
      return Wrong(key, fmt::format("'{}' {}", text, parsed.wrong),
                   "valid: if INPUT is SET and INPUT is SET then OUTPUT is SET");
    for (const FuzzyClause& clause : parsed.rule->conditions)
      CheckClause(clause, controller_.inputs, "an input", key);
    for (const FuzzyClause& clause : parsed.rule->conclusions)
      CheckClause(clause, controller_.outputs, "an output", key);
  }

  void CheckClause(const FuzzyClause& clause, const Variables& variables, std::string_view kind,
                   const std::string& key) {
    const auto variable = variables.find(clause.variable);
    if (variable == variables.end())
      return Wrong(key, fmt::format("'{}' is not {}", clause.variable, kind),
                   RemedyForName(clause.variable, NamesOf(variables)));
    if (!variable->second.sets.contains(clause.set))
      Wrong(key, fmt::format("'{}' has no set '{}'", clause.variable, clause.set),
            RemedyForName(clause.set, NamesOf(variable->second.sets)));
  }

  void CheckThatRulesSuffice() {
    std::vector<FuzzyRule> rules;
    for (const std::string& text : controller_.rules) rules.push_back(ParseRule(text).rule.value());
    for (const auto& [output, variable] : controller_.outputs) {
      std::map<std::string, Situation> at;
      if (!FindWithoutRule(rules, output, controller_.inputs.begin(), at)) continue;
      std::vector<std::string> places, sets;
      for (const auto& [input, situation] : at) {
        places.push_back(fmt::format("{} = {:g}", input, situation.x));
        sets.push_back(fmt::format("{} is {}", input, *situation.sets.begin()));
      }
      Wrong("rules", fmt::format("at {} none says what '{}' is", fmt::join(places, ", "), output),
            fmt::format("add one, as 'if {} then {} is {}'", fmt::join(sets, " and "), output,
                        variable.sets.begin()->first));
    }
  }

  // Situations of all inputs in which no rule tells an output; at: those of the inputs before next.
  bool FindWithoutRule(const std::vector<FuzzyRule>& rules, const std::string& output,
                       Variables::const_iterator next, std::map<std::string, Situation>& at) const {
    if (next == controller_.inputs.end())
      return std::none_of(rules.begin(), rules.end(), [&](const FuzzyRule& rule) {
        const auto holds = [&](const FuzzyClause& c) { return at.at(c.variable).sets.contains(c.set); };
        const auto tells = [&](const FuzzyClause& c) { return c.variable == output; };
        return std::any_of(rule.conclusions.begin(), rule.conclusions.end(), tells) &&
               std::all_of(rule.conditions.begin(), rule.conditions.end(), holds);
      });
    for (const Situation& situation : BarestSituations(next->second)) {
      at[next->first] = situation;
      if (FindWithoutRule(rules, output, std::next(next), at)) return true;
    }
    return false;
  }

  const FuzzyController& controller_;
  const std::string& key_;
  const Place& where_;
  Mistakes& mistakes_;
  bool sound_ = true;
};

}  // namespace

void CheckController(const FuzzyController& controller, const std::string& key, const Place& where,
                     Mistakes& mistakes) {
  ControllerCheck(controller, key, where, mistakes).All();
}

}  // namespace kestrel::control
