// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_height.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/nearest_name.h"

namespace kestrel::control {
namespace {

void CheckNames(const std::map<std::string, FuzzyVariable>& variables, const std::vector<std::string>& wanted,
                const std::string& key, const Place& where, Mistakes& mistakes) {
  for (const auto& [name, variable] : variables)
    if (std::find(wanted.begin(), wanted.end(), name) == wanted.end())
      mistakes.Add(where, key + '.' + name, "is not one of this law", RemedyForName(name, wanted));
  for (const std::string& name : wanted)
    if (!variables.contains(name)) mistakes.Add(where, key + '.' + name, "must be given");
}

}  // namespace

FuzzyController HeightController() {
  FuzzyController c;
  // Closer together towards the ground, where the height of commitment is near.
  c.inputs["error"] = {0,
                       1,
                       {{"near", {{0, 0, 0.1, 0.25}}},
                        {"low", {{0.1, 0.25, 0.25, 0.5}}},
                        {"middle", {{0.25, 0.5, 0.5, 0.9}}},
                        {"high", {{0.5, 0.9, 1, 1}}}}};
  c.inputs["rate"] = {-1,
                      1,
                      {{"rising", {{-1, -1, -0.4, 0}}},
                       {"still", {{-0.4, 0, 0, 0.4}}},
                       {"sinking", {{0, 0.4, 0.4, 0.8}}},
                       {"falling", {{0.4, 0.8, 1, 1}}}}};
  // As wide on either side, so that each alone comes to its middle.
  c.outputs["descent"] = {-0.25,
                          1.25,
                          {{"stopped", {{-0.25, 0, 0, 0.25}}},
                           {"creeping", {{0, 0.25, 0.25, 0.5}}},
                           {"slow", {{0.25, 0.5, 0.5, 0.75}}},
                           {"brisk", {{0.5, 0.75, 0.75, 1}}},
                           {"fast", {{0.75, 1, 1, 1.25}}}}};
  struct Row {
    const char *error, *rising, *still, *sinking, *falling;
  };
  for (const Row& row :
       {Row{"near", "slow", "creeping", "creeping", "stopped"},
        Row{"low", "brisk", "slow", "slow", "creeping"}, Row{"middle", "fast", "brisk", "brisk", "slow"},
        Row{"high", "fast", "fast", "fast", "brisk"}}) {
    const auto add = [&](const char* rate, const char* descent) {
      c.rules.push_back(
          fmt::format("if error is {} and rate is {} then descent is {}", row.error, rate, descent));
    };
    add("rising", row.rising), add("still", row.still), add("sinking", row.sinking);
    add("falling", row.falling);
  }
  c.t_norm = c.implication = "product";
  c.aggregation = "sum";
  return c;
}

void CheckHeight(const FuzzyHeight& height, const std::string& key, const Place& where, Mistakes& mistakes) {
  const FuzzyController& controller = height.controller;
  const std::string of_controller = key + ".controller";
  CheckController(controller, of_controller, where, mistakes);
  CheckNames(controller.inputs, {"error", "rate"}, of_controller + ".inputs", where, mistakes);
  CheckNames(controller.outputs, {"descent"}, of_controller + ".outputs", where, mistakes);
}

std::optional<double> FuzzyDescent(const FuzzyHeight& height, const FuzzyInference& inference, double error_m,
                                   double sink_m_s) {
  const auto outputs = Infer(
      inference, {{"error", error_m / height.error_scale_m}, {"rate", sink_m_s / height.rate_scale_m_s}});
  const auto descent = outputs.find("descent");
  if (descent == outputs.end()) return std::nullopt;
  return descent->second * height.descent_scale_m_s;
}

}  // namespace kestrel::control
