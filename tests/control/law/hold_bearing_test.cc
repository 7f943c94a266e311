// SPDX-License-Identifier: Apache-2.0
#include "control/law/hold_bearing.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "control/law/bearing_servo.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;

// An aircraft at constant speed and height, thesis (6.20), and what it sees of a thing at the origin.
struct Craft {
  Vector2d p_N;
  double heading = 0;
  double Azimuth() const {
    const Vector2d to = -p_N;
    return WrapAngle(std::atan2(to.y(), to.x()) - heading);
  }
};

struct Encounter {
  std::vector<Craft> path;
  HoldBearingState state;
  double min_range = 1e9;
};

Encounter Fly(Craft craft, const HoldBearingGains& gains, double seconds, double speed = 0.5) {
  Encounter e;
  const double dt = 0.01;
  for (int i = 0; i < seconds / dt; ++i) {
    const HoldBearingStep step = HoldBearing(e.state, craft.Azimuth(), gains);
    e.state = step.state;
    craft.heading += step.yaw_rate * dt;
    craft.p_N += speed * dt * Vector2d(std::cos(craft.heading), std::sin(craft.heading));
    e.min_range = std::min(e.min_range, craft.p_N.norm());
    e.path.push_back(craft);
  }
  return e;
}

TEST(HoldBearing, SeenToTheRightItIsPassedToItsLeftAndTheOtherWayRound) {
  const HoldBearingGains gains;
  const HoldBearingStep right = HoldBearing({}, 0.1, gains), left = HoldBearing({}, -0.1, gains),
                        ahead = HoldBearing({}, 0.0, gains);
  EXPECT_EQ(right.state.side, PassingSide::kLeft);
  EXPECT_LT(right.yaw_rate, 0);  // turns left, so that the bearing grows to 50 degrees
  EXPECT_EQ(left.state.side, PassingSide::kRight);
  EXPECT_GT(left.yaw_rate, 0);
  EXPECT_EQ(ahead.state.side, PassingSide::kRight);
  EXPECT_GT(ahead.yaw_rate, 0);
}

TEST(HoldBearing, TheSideIsKeptWhenTheOtherCrossesTheBow) {
  const HoldBearingStep first = HoldBearing({}, 0.1, {});
  const HoldBearingStep later = HoldBearing(first.state, -0.2, {});
  EXPECT_EQ(later.state.side, PassingSide::kLeft);
  EXPECT_LT(later.error, first.error);
  EXPECT_LT(later.yaw_rate, 0);
}

TEST(HoldBearing, TheErrorOfTheBearingFallsExponentiallyByTheDerivativeOfTheAzimuth) {
  // Far away the bearing turns by the yaw rate alone: eq. (6.29)'s assumption.
  Craft craft{{-1e7, 0}, 0.3};
  const HoldBearingGains gains{.lambda_per_s = 0.8, .bearing_deg = 50, .yaw_rate_limit_deg_s = 180};
  const double start = craft.Azimuth() + Radians(50);  // seen to the left: to be held at -50 degrees
  const Encounter e = Fly(craft, gains, 2);
  EXPECT_NEAR(e.path.back().Azimuth() + Radians(50), std::exp(-0.8 * 2) * start, 0.01 * std::abs(start));
}

TEST(HoldBearing, ItsSignIsThatOfTheMatrixOfTheSphere) {
  const SpherePoint target{1.2, -0.4};
  const auto J = SpherePointInteraction(target, 1e9);
  ASSERT_TRUE(J);
  const HoldBearingStep step =
      HoldBearing({PassingSide::kRight}, target.azimuth, {.lambda_per_s = 0.7, .yaw_rate_limit_deg_s = 180});
  EXPECT_NEAR((*J)(1, 5) * step.yaw_rate, -0.7 * step.error, 1e-9);
}

TEST(HoldBearing, BothSidesMissAThingDeadOnTheWayMirrorImages) {
  const Encounter left = Fly({{-5, -0.2}, 0}, {}, 14), right = Fly({{-5, 0.2}, 0}, {}, 14);
  EXPECT_EQ(left.state.side, PassingSide::kLeft);
  EXPECT_EQ(right.state.side, PassingSide::kRight);
  EXPECT_GT(left.min_range, 1.0);  // 5 m away, 50 degrees off
  EXPECT_NEAR(left.min_range, right.min_range, 1e-9);
  EXPECT_LT(left.path.back().p_N.y(), 0);
  EXPECT_GT(right.path.back().p_N.y(), 0);
}

TEST(HoldBearing, AHeldBearingOf50DegreesSpiralsInAndOneOf90Circles) {
  // Thesis 6.4.2: the greater the bearing, the greater the miss. Range falls by v cos(bearing).
  const double speed = 0.5;
  for (const double bearing_deg : {50.0, 70.0, 90.0}) {
    const Encounter e = Fly({{-8, -0.5}, 0}, {.lambda_per_s = 3, .bearing_deg = bearing_deg}, 12, speed);
    const double from = e.path[599].p_N.norm(), to = e.path.back().p_N.norm();
    const double held = e.path.back().Azimuth();
    EXPECT_NEAR(held, Radians(bearing_deg),
                Radians(4));  // a steady lag of the line of sight's rate over lambda
    EXPECT_NEAR(from - to, speed * 6 * std::cos(held), 0.05);
  }
}

TEST(HoldBearing, TurnsTheShorterWay) {
  // From 170 degrees to the left to 50 to the right it is 140 over the stern: the bow turns right.
  const HoldBearingStep step = HoldBearing({PassingSide::kLeft}, Radians(-170), {});
  EXPECT_NEAR(step.error, Radians(140), 1e-12);
  EXPECT_GT(step.yaw_rate, 0);
}

TEST(HoldBearing, WithoutABearingItFliesStraightOnAndRemembersTheSide) {
  for (const std::optional<double> none : {std::optional<double>(), std::optional(std::nan(""))}) {
    const HoldBearingStep step = HoldBearing({PassingSide::kLeft}, none, {});
    EXPECT_EQ(step.status, HoldBearingStatus::kNoBearing);
    EXPECT_EQ(step.yaw_rate, 0);
    EXPECT_EQ(step.state.side, PassingSide::kLeft);
    EXPECT_FALSE(HoldBearing({}, none, {}).state.side);
  }
}

TEST(HoldBearing, TheYawRateIsLimited) {
  const HoldBearingGains gains{.lambda_per_s = 5, .bearing_deg = 90, .yaw_rate_limit_deg_s = 30};
  EXPECT_NEAR(HoldBearing({PassingSide::kLeft}, -0.5, gains).yaw_rate, -Radians(30), 1e-12);
  EXPECT_NEAR(HoldBearing({PassingSide::kRight}, 0.5, gains).yaw_rate, Radians(30), 1e-12);
}

}  // namespace
}  // namespace kestrel::control
