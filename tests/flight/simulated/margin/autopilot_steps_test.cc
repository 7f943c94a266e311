// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/margin/autopilot_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "flight/simulated/scenario.h"

namespace kestrel::flight {
namespace {

// A dead time more turns the answer by its own phase at every frequency and leaves its gain, so the margins by
// the steps are those of before less that: of the phase by w tau, of the delay by tau.
TEST(AutopilotSteps, ADeadTimeComesOutAsOneInEveryAxis) {
  constexpr double kDelay_s = 0.4;
  const LoadedScenario prompt = LoadScenario("hover", {"seed=31"});
  const LoadedScenario late = LoadScenario(
      "hover",
      {"seed=31", "autopilot.level_delay_s=0.4", "autopilot.climb_delay_s=0.4", "autopilot.yaw_delay_s=0.4"});
  const AutopilotSteps before = StepAutopilot(prompt.simulator), after = StepAutopilot(late.simulator);
  for (const auto axis : {&AutopilotSteps::level, &AutopilotSteps::climb, &AutopilotSteps::turn}) {
    EXPECT_NEAR((before.*axis).answer.back(), 1, 0.05);
    EXPECT_NEAR((after.*axis).Late_s() - (before.*axis).Late_s(), kDelay_s, 0.06);
    for (const double w : {0.5, 1.0, 2.0}) {
      const std::complex<double> turned = (after.*axis).At(w) / (before.*axis).At(w);
      EXPECT_NEAR(std::abs(turned), 1, 0.06) << w;
      EXPECT_NEAR(std::arg(turned), -w * kDelay_s, 0.08) << w;
    }
    const auto margins = [&](const AutopilotSteps& steps) {
      return control::Margins([&](double w) { return control::OpenLoop(steps.*axis, {0.9}, w); });
    };
    EXPECT_NEAR(margins(before).delay_s - margins(after).delay_s, kDelay_s, 0.1);  // the phase above, at 0.9
  }
}

}  // namespace
}  // namespace kestrel::flight
