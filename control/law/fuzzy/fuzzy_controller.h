// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/law/fuzzy/fuzzy_set.h"

// A controller in words, after Mamdani and Assilian (1975): sets with names over the range of each input and
// output, and rules between them. The thesis has its landings controlled by one (5.3.1, after Olivares-Méndez
// et al. 2010), and prints neither its sets nor its rules.
namespace kestrel::control {

// A number and the sets in which it may be. Beyond its range an input counts as at the nearer end.
struct FuzzyVariable {
  double low = -1, high = 1;
  std::map<std::string, FuzzySet> sets;
};

inline void Fields(FieldVisitor& v, FuzzyVariable& x) {
  v(Required("low", "lower end of its range"), x.low, -1e6, 1e6);
  v(Required("high", "upper end of its range"), x.high, -1e6, 1e6);
  v(Required("sets", "fuzzy sets by the names that rules have for them"), x.sets);
}

struct FuzzyController {
  std::map<std::string, FuzzyVariable> inputs, outputs;
  std::vector<std::string> rules;  // "if error is high and rate is falling then descent is slow"
  std::string t_norm = "min", implication = "min", aggregation = "max";
};

inline void Fields(FieldVisitor& v, FuzzyController& c) {
  v({"inputs", "variables that conditions of rules name"}, c.inputs);
  v({"outputs", "variables that conclusions of rules name"}, c.outputs);
  v({"rules", "rules in words: if INPUT is SET and INPUT is SET then OUTPUT is SET"}, c.rules);
  v({"t_norm", "how far a rule fires, from the memberships of its conditions"}, c.t_norm, {"min", "product"});
  v({"implication", "how far a rule fires cuts off (min) or scales (product) the set of its conclusion"},
    c.implication, {"min", "product"});
  v({"aggregation", "how the sets of several rules are joined to the one whose centroid is the output"},
    c.aggregation, {"max", "sum"});
}

// What its fields allow and their sum does not: a range or corners that fall, a place in the range of an input
// that no set covers, an output's set that lies outside of its range, a rule that is none or names what is not
// there, inputs at which no rule says what an output is. key: of the controller in its file.
void CheckController(const FuzzyController& controller, const std::string& key, const Place& where,
                     Mistakes& mistakes);

}  // namespace kestrel::control
