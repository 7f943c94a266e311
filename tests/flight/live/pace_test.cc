// SPDX-License-Identifier: Apache-2.0
#include "flight/live/pace.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kestrel::flight {
namespace {

constexpr double kFrame_s = 1 / 32.0;

// Flies frames as the pace lets it, at a wall clock that only waiting and `work_s` a frame move; returns what the wall
// clock then says.
double Fly(Pace& pace, int frames, double wall_s, double& t_s, double work_s = 0) {
  for (int i = 0; i < frames; ++i) {
    t_s += kFrame_s;
    wall_s += work_s;
    pace.Flown(wall_s, t_s);
    const double wait_s = pace.Wait_s(wall_s, t_s);
    if (!std::isfinite(wait_s)) return wall_s;
    wall_s += wait_s;
  }
  return wall_s;
}

TEST(Pace, FliesAtTheSpeedThatWasAskedFor) {
  for (const double speed : {0.1, 0.5, 1.0, 3.0, 100.0}) {
    Pace pace(speed);
    double t_s = 0;
    const double first_s = Fly(pace, 1, 10, t_s);
    const int frames = static_cast<int>(std::lround(10 * speed / kFrame_s));  // of 10 s of the wall clock
    EXPECT_NEAR(Fly(pace, frames, first_s, t_s) - first_s, 10, 1e-9) << speed;
    EXPECT_NEAR(pace.real_time_factor(), speed, 0.11 * speed);
  }
}

TEST(Pace, AsFastAsItGoesWaitsForNothing) {
  Pace pace(Pace::kAsFast);
  double t_s = 0;
  EXPECT_EQ(Fly(pace, 1000, 10, t_s), 10);
}

TEST(Pace, PausedWaitsForEverAndOneStepIsOneFrame) {
  Pace pace(1);
  double t_s = 0;
  double wall_s = Fly(pace, 3, 10, t_s);
  pace.Pause();
  EXPECT_TRUE(std::isinf(pace.Wait_s(wall_s, t_s)));
  EXPECT_EQ(pace.real_time_factor(), 0);
  pace.Step();
  EXPECT_EQ(pace.Wait_s(wall_s, t_s), 0);
  const double before_s = t_s;
  Fly(pace, 10, wall_s, t_s);
  EXPECT_NEAR(t_s - before_s, kFrame_s, 1e-12);
  pace.Step();
  pace.Step();
  Fly(pace, 10, wall_s, t_s);
  EXPECT_NEAR(t_s - before_s, 3 * kFrame_s, 1e-12);
}

TEST(Pace, AfterAPauseNothingIsCaughtUp) {
  Pace pace(1);
  double t_s = 0;
  double wall_s = Fly(pace, 3, 10, t_s);
  pace.Pause();
  pace.Resume();
  wall_s += 60;
  pace.Flown(wall_s, t_s);
  const double begun_s = wall_s + pace.Wait_s(wall_s, t_s);
  EXPECT_NEAR(Fly(pace, 32, begun_s, t_s) - begun_s, 1, 1e-9);
}

TEST(Pace, OfWhatTheMachineIsLateByOnlyALittleIsCaughtUp) {
  Pace pace(1);
  double t_s = 0;
  double wall_s = Fly(pace, 2, 10, t_s);
  wall_s = Fly(pace, 1, wall_s, t_s, 5);  // one frame takes 5 s
  EXPECT_NEAR(Fly(pace, 32, wall_s, t_s) - wall_s, 1 - Pace::kCatchUp_s, 1e-9);
}

TEST(Pace, AnotherSpeedHoldsFromNowOn) {
  Pace pace(1);
  double t_s = 0;
  const double wall_s = Fly(pace, 32, 10, t_s);
  pace.SetSpeed(2);
  EXPECT_NEAR(Fly(pace, 33, wall_s, t_s) - wall_s, 0.5, 1e-9);
}

TEST(Pace, SpeedsThatAreNoneAreNotValid) {
  for (const double speed : {0.0, 0.1, 1.0, 100.0}) EXPECT_TRUE(Pace::Valid(speed)) << speed;
  for (const double speed : {-1.0, 0.01, 101.0, std::nan(""), HUGE_VAL})
    EXPECT_FALSE(Pace::Valid(speed)) << speed;
}

}  // namespace
}  // namespace kestrel::flight
