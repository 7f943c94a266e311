// SPDX-License-Identifier: Apache-2.0
#include "mission/touch_down/go_around.h"

#include <gmock/gmock.h>

#include <cmath>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"
#include "mission/touch_down/touch_down_records.h"
#include "mission/touch_down/wind_from_lean.h"

namespace kestrel::mission {
namespace {

using Advice = GoAround::Advice;

constexpr double kLastLook_m = 0.7;
const TouchDownLimits kLimits{.tilt_deg = 10, .sink_m_s = 0.6, .speed_m_s = 0.6, .wind_m_s = 8};
const GoAroundParameters kRule{
    .decision_m = 1.5, .share = 0.7, .steady_s = 1, .wait_first = true, .wait_s = 5, .attempts = 2};
const ExpectedTouch kCalm{Radians(3), 0.2, 0.1, 3};

ExpectedTouch Leaning(double tilt_deg) {
  ExpectedTouch touch = kCalm;
  touch.tilt = Radians(tilt_deg);
  return touch;
}

TEST(GoAroundTest, InCalmAirNothingHoldsItUp) {
  GoAround rule(kLimits, kRule);
  for (double height = 5, t = 0; height > 0; height -= 0.01, t += 0.05)
    ASSERT_EQ(rule.Ask(t, height, kLastLook_m, kCalm), Advice::kApproach) << height;
  EXPECT_TRUE(rule.committed());
  EXPECT_EQ(rule.attempt(), 1);
}

TEST(GoAroundTest, ItWaitsAtTheDecisionHeightUntilAllHasBeenWithinItsShareForAWhile) {
  for (const ExpectedTouch& rough : {Leaning(7.1), ExpectedTouch{0, 0.43, 0, 0}, ExpectedTouch{0, 0, 0.43, 0},
                                     ExpectedTouch{0, 0, 0, 8.1}}) {
    GoAround rule(kLimits, kRule);
    EXPECT_EQ(rule.Ask(0, 1.6, kLastLook_m, rough), Advice::kApproach);
    EXPECT_EQ(rule.Ask(1, 1.5, kLastLook_m, rough), Advice::kWait);
    EXPECT_EQ(rule.Ask(1.9, 1.5, kLastLook_m, kCalm), Advice::kWait);
    EXPECT_EQ(rule.Ask(2.0, 1.5, kLastLook_m, kCalm), Advice::kApproach);
    EXPECT_TRUE(rule.committed());
  }
}

TEST(GoAroundTest, TheFirstApproachWaitsForTheWindAloneWhereItIsToldSo) {
  GoAroundParameters first_free = kRule;
  first_free.wait_first = false;
  GoAround rule(kLimits, first_free);
  EXPECT_EQ(rule.Ask(0, 1.5, kLastLook_m, {0, 0, 0, 9}), Advice::kWait);
  EXPECT_EQ(rule.Ask(1.1, 1.5, kLastLook_m, Leaning(9)), Advice::kApproach);
  EXPECT_EQ(rule.Ask(2, 0.6, kLastLook_m, Leaning(9)), Advice::kGoAround);
  EXPECT_EQ(rule.Ask(5, 1.5, kLastLook_m, Leaning(9)), Advice::kWait);  // the second does not
}

TEST(GoAroundTest, LowDownItBreaksOffClimbsAndTriesAgainAndInTheEndAborts) {
  GoAround rule(kLimits, kRule);
  ASSERT_EQ(rule.Ask(0, 1.5, kLastLook_m, kCalm), Advice::kApproach);
  EXPECT_EQ(rule.Ask(1, 0.8, kLastLook_m, Leaning(9)), Advice::kApproach);  // high enough to come right yet
  EXPECT_EQ(rule.Ask(2, 0.6, kLastLook_m, Leaning(6.9)), Advice::kApproach);
  EXPECT_EQ(rule.Ask(3, 0.5, kLastLook_m, Leaning(7.1)), Advice::kGoAround);
  EXPECT_EQ(rule.attempt(), 2);
  EXPECT_EQ(rule.Ask(4, 0.9, kLastLook_m, kCalm),
            Advice::kGoAround);  // up to the decision height, calm or not
  EXPECT_EQ(rule.Ask(5, 1.5, kLastLook_m, kCalm), Advice::kApproach);
  EXPECT_EQ(rule.Ask(6, 0.5, kLastLook_m, Leaning(8)), Advice::kAbort);
  EXPECT_TRUE(rule.aborted());
  EXPECT_TRUE(rule.climbing());
  EXPECT_EQ(rule.Ask(7, 1.6, kLastLook_m, kCalm), Advice::kAbort);
  EXPECT_FALSE(rule.climbing());
  EXPECT_EQ(rule.attempt(), 2);
}

TEST(GoAroundTest, AWaitThatIsTooLongIsAnApproachLess) {
  GoAround rule(kLimits, kRule);
  EXPECT_EQ(rule.Ask(0, 1.5, kLastLook_m, Leaning(20)), Advice::kWait);
  EXPECT_EQ(rule.Ask(2, 1.7, kLastLook_m, Leaning(20)), Advice::kWait);  // a gust lifts it: it waits yet
  EXPECT_EQ(rule.Ask(4.9, 1.5, kLastLook_m, Leaning(20)), Advice::kWait);
  EXPECT_EQ(rule.Ask(5.1, 1.4, kLastLook_m, Leaning(20)), Advice::kGoAround);
  EXPECT_EQ(rule.Ask(6, 1.49, kLastLook_m, Leaning(20)), Advice::kGoAround);
  EXPECT_EQ(rule.Ask(7, 1.5, kLastLook_m, Leaning(20)), Advice::kWait);
  EXPECT_EQ(rule.Ask(12.1, 1.5, kLastLook_m, Leaning(20)), Advice::kAbort);
}

TEST(GoAroundTest, RefusesALastLookAboveTheDecisionHeight) {
  Mistakes mistakes;
  CheckGoAround(kRule, 1.4, "flight.commit_m", "landing.yaml", mistakes);
  EXPECT_TRUE(mistakes.empty());
  CheckGoAround(kRule, 1.6, "flight.commit_m", "landing.yaml", mistakes);
  ASSERT_EQ(mistakes.all().size(), 1u);
  EXPECT_EQ(mistakes.all()[0].key, "flight.go_around.decision_m");
}

TEST(WindFromLeanTest, TellsTheAirThatTheLeanBalancesAndWhereItComesFrom) {
  WindFromLean wind(0.18);
  control::VehicleState state;
  for (int i = 0; i < 1000; ++i) {
    state.t_s = 0.05 * i;
    // The air blows to the east at 6 m/s: it leans west, left side down, when it heads north. Between, it rocks.
    const double lean = -std::atan(0.18 * 6 / kGravity_m_s2) + 0.05 * std::sin(6 * state.t_s);
    state.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({0, 0, lean}));
    wind.Add(state);
  }
  EXPECT_NEAR(wind.air_N().y(), 6, 0.3);
  EXPECT_NEAR(wind.air_N().x(), 0, 1e-9);
}

TEST(TouchDownRecordsTest, LandedWithinItsLimitsOrAbortedIsInOrderAndNothingElse) {
  const auto ends = [](std::map<std::string, double> touch, bool landed, std::string_view outcome) {
    auto report = std::make_shared<TouchDownReport>();
    report->limits = kLimits;
    LogRow row;
    row.estimate.landed = landed;
    row.decision.report = report;
    row.decision.outcome = outcome;
    AddTouchDownMetrics({row}, touch);
    return touch;
  };
  const std::map<std::string, double> gentle = {
      {"touchdown_tilt_deg", 9.9}, {"touchdown_sink_m_s", 0.3}, {"touchdown_speed_m_s", 0.3}};
  EXPECT_EQ(ends(gentle, true, "landed").at("within_limits_or_aborted"), 1);
  EXPECT_EQ(ends({}, false, "aborted").at("within_limits_or_aborted"), 1);
  EXPECT_EQ(ends({}, false, "pad not found").at("within_limits_or_aborted"), 0);
  EXPECT_EQ(ends({}, false, "").at("within_limits_or_aborted"), 0);
  EXPECT_EQ(ends(gentle, false, "").at("within_limits_or_aborted"), 0);  // it touched, and did not stay
  for (const char* metric : {"touchdown_tilt_deg", "touchdown_sink_m_s", "touchdown_speed_m_s"}) {
    std::map<std::string, double> hard = gentle;
    hard[metric] = 10.1;
    EXPECT_EQ(ends(hard, true, "landed").at("within_limits_or_aborted"), 0) << metric;
    EXPECT_EQ(ends(hard, true, "landed").at("touchdown_beyond_limits"), 1) << metric;
    EXPECT_EQ(ends(hard, false, "aborted").at("within_limits_or_aborted"), 0) << metric;
  }
}

}  // namespace
}  // namespace kestrel::mission
