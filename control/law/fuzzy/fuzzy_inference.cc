// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_inference.h"

#include <algorithm>
#include <utility>

#include "control/law/fuzzy/centroid.h"

namespace kestrel::control {

FuzzyInference MakeInference(FuzzyController controller) {
  FuzzyInference inference;
  for (const std::string& text : controller.rules) inference.rules.push_back(ParseRule(text).rule.value());
  inference.controller = std::move(controller);
  return inference;
}

double Strength(const FuzzyInference& inference, const FuzzyRule& rule,
                const std::map<std::string, double>& inputs) {
  const bool product = inference.controller.t_norm == "product";
  double strength = 1;
  for (const FuzzyClause& condition : rule.conditions) {
    const FuzzyVariable& variable = inference.controller.inputs.at(condition.variable);
    const double x = std::clamp(inputs.at(condition.variable), variable.low, variable.high);
    const double membership = Membership(variable.sets.at(condition.set), x);
    strength = product ? strength * membership : std::min(strength, membership);
  }
  return strength;
}

std::map<std::string, double> Infer(const FuzzyInference& inference,
                                    const std::map<std::string, double>& inputs) {
  const FuzzyController& controller = inference.controller;
  const bool cut_off = controller.implication == "min";
  std::map<std::string, std::vector<ImpliedSet>> implied;
  for (const FuzzyRule& rule : inference.rules) {
    const double strength = Strength(inference, rule, inputs);
    if (!(strength > 0)) continue;
    for (const FuzzyClause& conclusion : rule.conclusions) {
      const FuzzySet& set = controller.outputs.at(conclusion.variable).sets.at(conclusion.set);
      implied[conclusion.variable].push_back(cut_off ? CutOff(set, strength) : Scaled(set, strength));
    }
  }
  const Aggregation aggregation = controller.aggregation == "sum" ? Aggregation::kSum : Aggregation::kMax;
  std::map<std::string, double> outputs;
  for (const auto& [name, sets] : implied) {
    const FuzzyVariable& variable = controller.outputs.at(name);
    if (const auto centroid = Centroid(sets, aggregation, variable.low, variable.high))
      outputs[name] = *centroid;
  }
  return outputs;
}

}  // namespace kestrel::control
