// SPDX-License-Identifier: Apache-2.0
#include "control/safety/release.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

namespace kestrel::control {
namespace {

constexpr double kStep_s = 0.02;

// An aircraft 5 m up that sinks, as a script changes it; how it is let go, and after how long.
std::pair<Release, double> After(const std::function<void(double, Situation&)>& script) {
  ReleaseState state{100, {}};
  Situation now;
  now.pilot_allows = true;
  now.state.landed = false;
  now.state.mode = FlightMode::kVelocity;
  now.state.p_NB = {0, 0, -5};
  for (int step = 0; step < 10000; ++step) {
    now.t_s = state.since_s + step * kStep_s;
    now.state.v_N = {0, 0, 0.9};
    now.state_age_s = 0.02;
    script(step * kStep_s, now);
    const Release release = LetGo(now, state, {});
    if (release != Release::kHolding) return {release, step * kStep_s};
  }
  return {Release::kHolding, 0};
}

TEST(Release, AnAircraftThatObeysIsHeldUntilItStandsStill) {
  // A velocity that follows 0.85 s late.
  const auto [release, after_s] =
      After([](double t_s, Situation& now) { now.state.v_N.z() = 0.9 * std::exp(-t_s / 0.85); });
  EXPECT_EQ(release, Release::kHeld);
  EXPECT_NEAR(after_s, 0.85 * std::log(0.9 / 0.25) + 1, 2 * kStep_s);
}

TEST(Release, OnePassThroughZeroIsNotStandingStill) {
  const auto [release, after_s] = After([](double t_s, Situation& now) {
    now.state.v_N.z() = 0.9 * std::cos(2 * t_s);  // slower than 0.25 m/s for 0.28 s each time
  });
  EXPECT_EQ(release, Release::kNotObeyed);
  EXPECT_NEAR(after_s, 5, 2 * kStep_s);
}

TEST(Release, WhoTurnsDoesNotStandStill) {
  const auto turning = After([](double, Situation& now) {
    now.state.v_N.setZero();
    now.state.w_B.z() = -0.5;
  });
  EXPECT_EQ(turning.first, Release::kNotObeyed);
  const auto still = After([](double, Situation& now) { now.state.v_N.setZero(); });
  EXPECT_EQ(still.first, Release::kHeld);
  EXPECT_NEAR(still.second, 1, 2 * kStep_s);
}

TEST(Release, ThePilotHasItAtOnceWhateverTheRest) {
  const auto [release, after_s] = After([](double t_s, Situation& now) {
    now.pilot_allows = t_s < 0.5;
    now.state.landed = t_s > 0.6;
  });
  EXPECT_EQ(release, Release::kPilot);
  EXPECT_NEAR(after_s, 0.5, 2 * kStep_s);
}

TEST(Release, OnTheGroundThereIsNothingToHold) {
  EXPECT_EQ(After([](double, Situation& now) { now.state.landed = true; }), std::pair(Release::kLanded, 0.0));
}

TEST(Release, AnAutopilotThatHoldsByItselfIsNotAskedAgain) {
  EXPECT_EQ(After([](double, Situation& now) { now.state.mode = FlightMode::kHold; }),
            std::pair(Release::kOwnHold, 0.0));
}

TEST(Release, ALostStateIsToldAllTheSameAndNotSaidToHaveObeyed) {
  for (const bool old : {false, true}) {
    const auto [release, after_s] = After([old](double, Situation& now) {
      now.state.v_N.setZero();
      now.state.landed = true;  // which is not believed either
      if (old)
        now.state_age_s = 0.6;
      else
        now.state.p_NB.x() = 3e38;
    });
    EXPECT_EQ(release, Release::kStateLost);
    EXPECT_NEAR(after_s, 5, 2 * kStep_s);
  }
  const auto again = After([](double t_s, Situation& now) {
    if (t_s < 2) now.state_age_s = 3;
    now.state.v_N.setZero();
  });
  EXPECT_EQ(again.first, Release::kHeld);
  EXPECT_NEAR(again.second, 3, 2 * kStep_s);
}

TEST(Release, WhoWasNeverHeardIsNotWaitedFor) {
  EXPECT_EQ(After([](double, Situation& now) { now.state_age_s.reset(); }),
            std::pair(Release::kStateLost, 0.0));
}

TEST(Release, EveryEndHasWordsOfItsOwn) {
  EXPECT_EQ(TextOf(Release::kHeld, 1.84), "held: standing still 1.8 s after velocity zero");
  EXPECT_EQ(TextOf(Release::kNotObeyed, 5), "velocity zero not obeyed within 5.0 s");
  EXPECT_NE(TextOf(Release::kPilot, 0), TextOf(Release::kOwnHold, 0));
}

}  // namespace
}  // namespace kestrel::control
