// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/sight_mission.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "scenarios/avoid/avoid_report.h"
#include "tests/scenarios/ball_pictures.h"

namespace kestrel::scenarios {
namespace {

AvoidFlight BySight() {
  AvoidFlight flight;
  flight.decides_by = "sight";
  flight.end_s = 2;
  flight.avoidance.hold.bearing_deg = 20;  // within the view of the test's camera
  return flight;
}

// One look at a mark at an azimuth, at a time.
mission::Decision Seen(mission::Mission& mission, double t_s, double azimuth, bool shown = true) {
  BallPictures pictures;
  const control::VehicleState state = LevelAt(t_s, {0, 0, -4}, 0);
  const Ball mark{.p_N = {6 * std::cos(azimuth), 6 * std::sin(azimuth), -4}};
  const cv::Mat image = pictures.Draw(shown ? std::vector<Ball>{mark} : std::vector<Ball>{}, state);
  return mission.Step({image, t_s, static_cast<std::int64_t>(20 * t_s)}, state);
}

control::VelocitySetpoint CommandOf(const mission::Decision& d) {
  return std::get<control::VelocitySetpoint>(*d.setpoint);
}

TEST(SightMission, HoldsTheBearingOfOneImageByTheLawAndNothingElse) {
  for (const double side : {1.0, -1.0}) {
    const auto mission = MakeSightMission(BySight(), BallPictures::Parts());
    const double azimuth = side * Radians(8);
    const mission::Decision d = Seen(*mission, 0.1, azimuth);
    ASSERT_TRUE(EncounterOf(d) && EncounterOf(d)->wanted);
    EXPECT_FALSE(EncounterOf(d)->range_m);
    EXPECT_NEAR(EncounterOf(d)->azimuth, azimuth, 0.01);
    EXPECT_NEAR(*EncounterOf(d)->wanted, side * Radians(20), 1e-9);
    // (6.29): it falls by the yaw rate, so the law has no minus.
    EXPECT_NEAR(CommandOf(d).yaw_rate, EncounterOf(d)->azimuth - side * Radians(20), 1e-9);
    EXPECT_NEAR(CommandOf(d).v_H.x(), 0.5, 1e-12);
    EXPECT_EQ(d.phase, "avoid");
  }
}

TEST(SightMission, FliesStraightOnWithoutAMarkAndEndsByHand) {
  const auto mission = MakeSightMission(BySight(), BallPictures::Parts());
  mission::Decision d = Seen(*mission, 0.1, 0, false);
  EXPECT_EQ(CommandOf(d).yaw_rate, 0);
  EXPECT_EQ(d.phase, "cruise");
  EXPECT_TRUE(d.outcome.empty());
  d = Seen(*mission, 2, 0.1);
  EXPECT_EQ(d.outcome, "ended by hand");
  EXPECT_EQ(CommandOf(d).v_H, Eigen::Vector3d::Zero());
  EXPECT_TRUE(mission->Accomplished());
}

}  // namespace
}  // namespace kestrel::scenarios
