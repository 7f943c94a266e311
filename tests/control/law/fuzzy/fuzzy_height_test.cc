// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_height.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace kestrel::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Law {
  FuzzyHeight height;
  FuzzyInference inference = MakeInference(height.controller);
  double operator()(double error_m, double sink_m_s) const {
    return FuzzyDescent(height, inference, error_m, sink_m_s).value();
  }
};

TEST(FuzzyHeight, DescendsFasterTheHigherItIsAndSlowerTheFasterItSinks) {
  const Law law;
  constexpr int kSteps = 40;
  const auto height = [](int i) { return 6.0 * i / kSteps; };
  const auto sink = [](int i) { return -1.2 + 2.4 * i / kSteps; };
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double here = law(height(i), sink(j));
      EXPECT_GE(here, -1e-12);
      EXPECT_LE(here, law.height.descent_scale_m_s + 1e-12);
      EXPECT_GE(law(height(i + 1), sink(j)), here - 1e-12) << height(i) << ' ' << sink(j);
      EXPECT_LE(law(height(i), sink(j + 1)), here + 1e-12) << height(i) << ' ' << sink(j);
    }
}

TEST(FuzzyHeight, LeapsNowhere) {
  const Law law;
  constexpr double kStep = 1e-3;
  for (double at = 0; at < 5; at += kStep)
    for (const double sink : {-0.5, 0.0, 0.3, 0.7})
      EXPECT_NEAR(law(at, sink), law(at + kStep, sink), kStep) << at;  // slopes of no more than 1/s
}

TEST(FuzzyHeight, AScaleStretchesItsAxisAlone) {
  Law law, stretched;
  stretched.height.error_scale_m *= 2;
  stretched.height.rate_scale_m_s *= 3;
  stretched.height.descent_scale_m_s *= 0.5;
  EXPECT_NEAR(stretched(2 * 1.7, 3 * 0.3), 0.5 * law(1.7, 0.3), 1e-12);
}

TEST(FuzzyHeight, NumbersThatAreNotFiniteFireNoRule) {
  const Law law;
  EXPECT_FALSE(FuzzyDescent(law.height, law.inference, NAN, 0));
  EXPECT_FALSE(FuzzyDescent(law.height, law.inference, 1, NAN));
}

TEST(FuzzyHeight, AnotherVariableIsRefused) {
  FuzzyHeight height;
  height.controller.inputs["drift"] = height.controller.inputs.at("rate");
  height.controller.outputs["descent"].sets.erase("fast");
  Mistakes mistakes;
  CheckHeight(height, "flight.fuzzy", Place("f.yaml", 2), mistakes);
  EXPECT_THAT(
      mistakes.Texts(),
      ::testing::Contains(
          "f.yaml:2: flight.fuzzy.controller.inputs.drift: is not one of this law; valid: error, rate"));
  EXPECT_THAT(mistakes.Texts(), ::testing::Contains(HasSubstr("'descent' has no set 'fast'")));
  height = {};
  height.controller.inputs.erase("rate");
  Mistakes others;
  CheckHeight(height, "flight.fuzzy", Place("f.yaml", 2), others);
  EXPECT_THAT(others.Texts(),
              ::testing::Contains("f.yaml:2: flight.fuzzy.controller.inputs.rate: must be given"));
}

}  // namespace
}  // namespace kestrel::control
