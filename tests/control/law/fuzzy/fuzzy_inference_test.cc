// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_inference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/law/fuzzy/fuzzy_height.h"
#include "tests/fuzzylite/fuzzylite.h"

namespace kestrel::control {
namespace {

using Values = std::map<std::string, double>;

// Of one input from 0 to 1 and two sets of its output, around 0 and 2.
FuzzyController Between() {
  FuzzyController c;
  c.inputs["error"] = {0, 1, {{"low", {{0, 0, 0, 1}}}, {"high", {{0, 1, 1, 1}}}}};
  c.outputs["speed"] = {-1, 3, {{"slow", {{-1, 0, 0, 1}}}, {"fast", {{1, 2, 2, 3}}}}};
  c.rules = {"if error is low then speed is slow", "if error is high then speed is fast"};
  return c;
}

double SpeedAt(const FuzzyController& controller, double error) {
  return Infer(MakeInference(controller), {{"error", error}}).at("speed");
}

// By hand: the areas of the two triangles are as the strengths w where they are scaled, and as w (2 - w) where
// they are cut off.
TEST(Inference, OfTwoRulesIsTheTableComputedByHand) {
  const double table[][3] = {
      // error, scaled, cut off
      {-1, 0, 0}, {0, 0, 0}, {0.25, 0.5, 7.0 / 11}, {0.5, 1, 1}, {0.75, 1.5, 15.0 / 11},
      {1, 2, 2},  {7, 2, 2}};
  for (const auto& [error, scaled, cut_off] : table)
    for (const char* aggregation : {"max", "sum"}) {  // the sets do not overlap
      FuzzyController c = Between();
      c.aggregation = aggregation;
      EXPECT_NEAR(SpeedAt(c, error), cut_off, 1e-15) << error;
      c.implication = "product";
      EXPECT_NEAR(SpeedAt(c, error), scaled, 1e-15) << error;
    }
}

TEST(Inference, ARuleFiresByTheMinimumOrTheProductOfItsConditions) {
  FuzzyController c = Between();
  c.inputs["rate"] = {0, 1, {{"some", {{0, 1, 1, 2}}}}};
  c.rules = {"if error is high and rate is some then speed is fast"};
  const auto strength = [&](const char* t_norm) {
    c.t_norm = t_norm;
    const FuzzyInference inference = MakeInference(c);
    return Strength(inference, inference.rules[0], {{"error", 0.5}, {"rate", 0.25}});
  };
  EXPECT_EQ(strength("min"), 0.25);
  EXPECT_EQ(strength("product"), 0.125);
}

TEST(Inference, AnOutputOfWhichNoRuleSaysAnythingIsNotThere) {
  FuzzyController c = Between();
  c.rules.pop_back();
  EXPECT_TRUE(Infer(MakeInference(c), {{"error", 1}}).empty());
  EXPECT_TRUE(Infer(MakeInference(Between()), {{"error", NAN}}).empty());
}

// Two inputs, two outputs, sets that overlap unevenly, rules with several conclusions and with one condition.
FuzzyController Uneven() {
  FuzzyController c;
  c.inputs["x"] = {
      -2, 3, {{"left", {{-2, -2, -1, 0.5}}}, {"middle", {{-1.5, 0.2, 0.7, 1.1}}}, {"right", {{0, 2, 3, 3}}}}};
  c.inputs["y"] = {0, 10, {{"small", {{-1, 0, 2, 6}}}, {"great", {{1, 9, 9, 12}}}}};
  c.outputs["u"] = {
      -1,
      1,
      {{"less", {{-1, -1, -0.6, 0.1}}}, {"same", {{-0.4, 0.1, 0.1, 0.5}}}, {"more", {{0, 0.5, 1, 1}}}}};
  c.outputs["w"] = {0, 5, {{"off", {{0, 0, 0, 3}}}, {"on", {{1, 4, 4.5, 6}}}}};
  c.rules = {"if x is left and y is small then u is more and w is on",
             "if x is left and y is great then u is same and w is on",
             "if x is middle then u is same and w is off",
             "if x is right and y is small then u is same",
             "if x is right and y is great then u is less and w is off",
             "if y is small then w is off"};
  return c;
}

// fuzzylite integrates by the middles of N intervals, which is exact where the curve is straight. An interval of
// length h is off by s h^2 / 8 at most where the slope changes by s. Over a range of 1 these curves have changes of
// slope of some 40 together and areas of at least 0.1, which makes 50 / N^2.
TEST(Inference, AgreesWithFuzzyliteOnAGrid) {
  constexpr int kSamples = 2000, kSteps = 8;
  int compared = 0;
  for (FuzzyController c : {Between(), Uneven(), HeightController()})
    for (const char* t_norm : {"min", "product"})
      for (const char* implication : {"min", "product"})
        for (const char* aggregation : {"max", "sum"}) {
          c.t_norm = t_norm, c.implication = implication, c.aggregation = aggregation;
          Mistakes mistakes;
          CheckController(c, "", Place{}, mistakes);
          ASSERT_TRUE(mistakes.empty()) << mistakes.Texts()[0];
          const FuzzyInference inference = MakeInference(c);
          fuzzylite::Engine engine(c, kSamples);
          for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; j <= kSteps; ++j) {
              Values inputs;
              for (const auto& [name, variable] : c.inputs)
                inputs[name] =
                    variable.low + (variable.high - variable.low) * (inputs.empty() ? i : j) / kSteps;
              const Values outputs = Infer(inference, inputs), theirs = engine.Outputs(inputs);
              for (const auto& [name, variable] : c.outputs) {
                const double tolerance = 50.0 / (kSamples * kSamples) * (variable.high - variable.low);
                ASSERT_TRUE(outputs.contains(name));
                EXPECT_NEAR(outputs.at(name), theirs.at(name), tolerance)
                    << name << " at " << i << ", " << j << ": " << t_norm << ' ' << implication << ' '
                    << aggregation;
                ++compared;
              }
              if (c.inputs.size() == 1) break;
            }
        }
  EXPECT_EQ(compared, 8 * (9 + 2 * 81 + 81));
}

}  // namespace
}  // namespace kestrel::control
