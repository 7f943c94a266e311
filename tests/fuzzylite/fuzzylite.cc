// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzzylite/fuzzylite.h"

#include <fl/Headers.h>

namespace kestrel::fuzzylite {
namespace {

void AddSets(fl::Variable& to, const control::FuzzyVariable& from) {
  to.setRange(from.low, from.high);
  for (const auto& [name, set] : from.sets) {
    const auto& at = set.corners;
    if (at[1] == at[2])
      to.addTerm(new fl::Triangle(name, at[0], at[1], at[3]));
    else
      to.addTerm(new fl::Trapezoid(name, at[0], at[1], at[2], at[3]));
  }
}

}  // namespace

struct Engine::Of {
  fl::Engine engine;
};

Engine::Engine(const control::FuzzyController& controller, int samples) : of_(std::make_unique<Of>()) {
  fl::Engine& engine = of_->engine;
  for (const auto& [name, variable] : controller.inputs) {
    auto* input = new fl::InputVariable(name);
    AddSets(*input, variable);
    engine.addInputVariable(input);
  }
  for (const auto& [name, variable] : controller.outputs) {
    auto* output = new fl::OutputVariable(name);
    AddSets(*output, variable);
    if (controller.aggregation == "sum")
      output->setAggregation(new fl::UnboundedSum);
    else
      output->setAggregation(new fl::Maximum);
    output->setDefuzzifier(new fl::Centroid(samples));
    engine.addOutputVariable(output);
  }
  const auto t_norm = [](const std::string& name) -> fl::TNorm* {
    if (name == "product") return new fl::AlgebraicProduct;
    return new fl::Minimum;
  };
  auto* rules = new fl::RuleBlock;
  rules->setConjunction(t_norm(controller.t_norm));
  rules->setImplication(t_norm(controller.implication));
  rules->setActivation(new fl::General);
  for (const std::string& text : controller.rules) rules->addRule(fl::Rule::parse(text, &engine));
  engine.addRuleBlock(rules);
}

Engine::~Engine() = default;

std::map<std::string, double> Engine::Outputs(const std::map<std::string, double>& inputs) {
  for (const auto& [name, value] : inputs) of_->engine.setInputValue(name, value);
  of_->engine.process();
  std::map<std::string, double> outputs;
  for (fl::OutputVariable* each : of_->engine.outputVariables()) outputs[each->getName()] = each->getValue();
  return outputs;
}

}  // namespace kestrel::fuzzylite
