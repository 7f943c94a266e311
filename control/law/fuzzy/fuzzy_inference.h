// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "control/law/fuzzy/fuzzy_controller.h"
#include "control/law/fuzzy/fuzzy_rule.h"

namespace kestrel::control {

// A controller whose rules have been read.
struct FuzzyInference {
  FuzzyController controller;
  std::vector<FuzzyRule> rules;
};

// Of a controller in which CheckController finds no mistake.
FuzzyInference MakeInference(FuzzyController controller);

// How far a rule fires, 0 to 1. inputs: by their names, each that the rule names.
double Strength(const FuzzyInference& inference, const FuzzyRule& rule,
                const std::map<std::string, double>& inputs);

// The outputs by their names: the centroid of what the rules that fire say of each. inputs: all, by their
// names. An output of which none says anything is not there, as with an input that is no number.
std::map<std::string, double> Infer(const FuzzyInference& inference,
                                    const std::map<std::string, double>& inputs);

}  // namespace kestrel::control
