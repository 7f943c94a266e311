// SPDX-License-Identifier: Apache-2.0
#include "control/release.h"

#include <gmock/gmock.h>

#include <limits>

namespace kestrel {
namespace {

// In flight at 1 m/s, heard 20 ms ago, velocity zero since t_s = 100.
class ReleaseTest : public testing::Test {
 protected:
  ReleaseTest() {
    now_.t_s = 100;
    now_.pilot_allows = true;
    now_.state.landed = false;
    now_.state.mode = FlightMode::kVelocity;
    now_.state.v_N = {0, 0, 1};
    now_.state_age_s = 0.02;
  }
  Release After(double seconds) {
    now_.t_s = 100 + seconds;
    return LetGo(now_, state_, limits_, release_);
  }
  Situation now_;
  SafetyLimits limits_;
  ReleaseLimits release_;
  ReleaseState state_{100, {}};
};

TEST_F(ReleaseTest, ItEndsOnceTheAircraftHasStoodStillForAWhile) {
  EXPECT_EQ(After(0), Release::kHolding);
  now_.state.v_N = {0.1, 0, -0.1};
  EXPECT_EQ(After(0.5), Release::kHolding);
  EXPECT_EQ(After(1.49), Release::kHolding);
  EXPECT_EQ(After(1.5), Release::kHeld);
}

TEST_F(ReleaseTest, AMomentOfRestIsNoHold) {
  now_.state.v_N.setZero();
  EXPECT_EQ(After(0.2), Release::kHolding);
  now_.state.v_N = {0, 0, 0.5};  // it swings through
  EXPECT_EQ(After(0.9), Release::kHolding);
  now_.state.v_N.setZero();
  EXPECT_EQ(After(1.3), Release::kHolding);
  EXPECT_EQ(After(2.3), Release::kHeld);
}

TEST_F(ReleaseTest, TurningIsNoStandingStill) {
  now_.state.v_N.setZero();
  now_.state.w_B = {0, 0, 0.5};
  EXPECT_EQ(After(1.5), Release::kHolding);
  EXPECT_EQ(After(release_.most_s), Release::kNotObeyed);
}

TEST_F(ReleaseTest, OneThatDoesNotObeyIsLetGoInTheEndAndSaidToBe) {
  EXPECT_EQ(After(4.9), Release::kHolding);
  EXPECT_EQ(After(5), Release::kNotObeyed);
  EXPECT_THAT(TextOf(Release::kNotObeyed, 5), testing::HasSubstr("not obeyed within 5.0 s"));
}

TEST_F(ReleaseTest, WithoutAStateNobodyCanSayWhetherItWasObeyed) {
  now_.state_age_s = 2;
  now_.state.v_N.setZero();
  EXPECT_EQ(After(2), Release::kHolding);
  EXPECT_EQ(After(5), Release::kStateLost);
  now_.state_age_s = 0.02;
  now_.state.p_NB.x() = 3e38;
  EXPECT_EQ(After(5), Release::kStateLost);
  now_.state_age_s.reset();  // never heard: there is nobody to be told
  EXPECT_EQ(After(0), Release::kStateLost);
}

TEST_F(ReleaseTest, WhatIsThePilotsOrOnTheGroundOrHoldsByItselfIsLeftAloneAtOnce) {
  now_.state.landed = true;
  EXPECT_EQ(After(0), Release::kLanded);
  now_.state.landed = false;
  now_.state.mode = FlightMode::kHold;
  EXPECT_EQ(After(0), Release::kOwnHold);
  now_.pilot_allows = false;
  EXPECT_EQ(After(0), Release::kPilot);
}

}  // namespace
}  // namespace kestrel
