// SPDX-License-Identifier: Apache-2.0
// Flights after a balloon and past others, judged by the simulator's truth, on seeds that no tuning was done
// on.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/acceptance/flown.h"

namespace kestrel {
namespace {

TEST(Follow, StepsOfTheReferenceSettleWithoutOvershoot) { ExpectCriteria(Flown("follow_step", 101)); }

TEST(Follow, TheDecoupledLawDoesSoToo) {
  ExpectCriteria(Flown("follow_step", 102, {"flight.law=decoupled"}));
}

TEST(Follow, ABalloonThatIsCarriedAboutStaysInViewAtItsDistance) { ExpectCriteria(Flown("follow", 101)); }

// It flies off faster than the aircraft can.
TEST(Follow, ABalloonThatIsLostMakesItStopLookAroundAndGiveUp) {
  const flight::FlightResult result = Flown("follow", 103,
                                            {"targets.0.roam_m_s=0", "targets.0.velocity_m_s=[2,14,0]",
                                             "flight.look_around.give_up_s=8", "wind.mean_m_s=0"});
  EXPECT_EQ(result.summary.outcome, "balloon not found");
  std::set<std::string_view> phases;
  for (const records::LogRow& row : result.rows) phases.insert(row.decision.phase);
  EXPECT_TRUE(phases.contains("stop"));
  EXPECT_TRUE(phases.contains("look around"));
  EXPECT_LT(result.rows.back().now.v_N.norm(), 0.3);
}

class AvoidFlights : public ::testing::TestWithParam<const char*> {};

TEST_P(AvoidFlights, PassAtADistanceAndReturnToTheCourse) {
  const flight::FlightResult result = Flown(GetParam(), 101);
  EXPECT_EQ(result.summary.outcome, "goal reached");
  ExpectCriteria(result);
}
INSTANTIATE_TEST_SUITE_P(PastOthers, AvoidFlights,
                         ::testing::Values("avoid_left_1", "avoid_left_2", "avoid_right_1", "avoid_right_2",
                                           "avoid", "avoid_contrast"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Avoid, WithoutAvoidanceItWouldCollide) {
  const flight::FlightResult result = Flown("avoid", 101, {"flight.avoids=false", "duration_s=12"});
  EXPECT_LT(result.summary.metrics.at("closest_m"), 1.5);
  EXPECT_EQ(result.summary.metrics.at("manoeuvred"), 0);
}

}  // namespace
}  // namespace kestrel
