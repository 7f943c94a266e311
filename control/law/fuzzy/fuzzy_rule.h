// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kestrel::control {

// "error is high"
struct FuzzyClause {
  std::string variable, set;
  bool operator==(const FuzzyClause&) const = default;
};

// "if error is high and rate is falling then descent is slow": conditions that hold together, and what
// follows. An "or" is two rules.
struct FuzzyRule {
  std::vector<FuzzyClause> conditions, conclusions;  // at least one of each
  bool operator==(const FuzzyRule&) const = default;
};

// Or at which word, counted from 1, a text stops being a rule, and what is said of it.
struct ParsedRule {
  std::optional<FuzzyRule> rule;
  std::string wrong;
};
ParsedRule ParseRule(std::string_view text);

// Whether a rule can name it: a single word that has no meaning of its own in rules.
bool IsFuzzyName(std::string_view name);

}  // namespace kestrel::control
