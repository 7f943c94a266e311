// SPDX-License-Identifier: Apache-2.0
#include "control/safety/safety.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const SafetyLimits kLimits;

// All is well: 10 m up, 5 m from the start, heading north-east.
Situation Sound() {
  Situation now;
  now.t_s = 100;
  now.pilot_allows = true;
  now.start_N = {200, -100, 3};
  now.state.p_NB = now.start_N + Eigen::Vector3d(3, 4, -10);
  now.state.R_NB = HeadingRotation(Radians(45));
  now.state_age_s = 0.02, now.image_age_s = 0.05;
  now.wanted = VelocitySetpoint{{1, -0.5, -0.2}, 0.3};
  return now;
}

SafeCommand Once(const Situation& now) { return MakeSafe(now, {}, kLimits); }

// After the hazard has lasted for longer than patience_s.
SafeCommand Later(Situation now) {
  SafetyState state = Once(now).state;
  now.t_s += kLimits.patience_s + 0.01;
  return MakeSafe(now, state, kLimits);
}

const VelocitySetpoint& Velocity(const SafeCommand& command) {
  return std::get<VelocitySetpoint>(*command.setpoint);
}

void ExpectHold(const SafeCommand& command) {
  EXPECT_EQ(command.reaction, Reaction::kHold);
  ASSERT_TRUE(command.setpoint);
  EXPECT_EQ(Velocity(command).v_H, Eigen::Vector3d::Zero());
  EXPECT_EQ(Velocity(command).yaw_rate, 0);
}

void ExpectSink(const SafeCommand& command) {
  EXPECT_EQ(command.reaction, Reaction::kSink);
  ASSERT_TRUE(command.setpoint);
  EXPECT_EQ(Velocity(command).v_H, Eigen::Vector3d(0, 0, kLimits.slow_m_s));
}

TEST(Safety, EachHazardHasOneRowAndTheRowsAreInTheOrderInWhichTheyAreJudged) {
  for (std::size_t i = 0; i < kReactions.size(); ++i)
    EXPECT_EQ(static_cast<std::size_t>(kReactions[i].hazard), i) << NameOf(kReactions[i].hazard);
}

TEST(Safety, WithinTheLimitsWhatWasAskedForGoesOutAsItIs) {
  const SafeCommand command = Once(Sound());
  EXPECT_EQ(command.reaction, Reaction::kFly);
  EXPECT_FALSE(command.limited);
  EXPECT_EQ(Velocity(command).v_H, Eigen::Vector3d(1, -0.5, -0.2));
  EXPECT_EQ(Velocity(command).yaw_rate, 0.3);
  EXPECT_EQ(Later(Sound()).reaction, Reaction::kFly);
}

TEST(Safety, PilotsSwitchOffNothingIsSent) {
  Situation now = Sound();
  now.pilot_allows = false;
  for (const SafeCommand& command : {Once(now), Later(now)}) {
    EXPECT_EQ(command.state.hazard, Hazard::kPilot);
    EXPECT_FALSE(command.setpoint);
  }
}

TEST(Safety, StateLostItHoldsAndThenLeavesItToTheAutopilot) {
  for (const auto& age : {std::optional<double>(), std::optional(0.51), std::optional(kNan)}) {
    Situation now = Sound();
    now.state_age_s = age;
    EXPECT_EQ(Once(now).state.hazard, Hazard::kStateLost);
    ExpectHold(Once(now));
    EXPECT_FALSE(Later(now).setpoint);
  }
}

TEST(Safety, AStateThatIsNotFiniteIsNone) {
  for (int which = 0; which < 5; ++which) {
    Situation now = Sound();
    if (which == 0) now.state.p_NB.x() = kNan;
    if (which == 1) now.state.v_N.y() = kInf;
    if (which == 2) now.state.R_NB.coeffs().z() = kNan;
    if (which == 3) now.state.w_B.x() = kNan;
    if (which == 4) now.state.t_s = kNan;
    EXPECT_EQ(Once(now).state.hazard, Hazard::kStateLost) << which;
    ExpectHold(Once(now));
  }
}

TEST(Safety, AStateThatNoAircraftCanHaveIsNone) {
  for (int which = 0; which < 4; ++which) {
    Situation now = Sound();
    if (which == 0) now.state.p_NB.x() = 3e38;
    if (which == 1) now.state.v_N.y() = 1e4;
    if (which == 2) now.state.R_NB.coeffs().setZero();
    if (which == 3) now.state.w_B.x() = 1e3;
    EXPECT_EQ(Once(now).state.hazard, Hazard::kStateLost) << which;
    ExpectHold(Once(now));
  }
  Situation far = Sound();
  far.state.p_NB.x() = 9e4, far.state.v_N.y() = 150, far.state.w_B.x() = 30;
  EXPECT_EQ(Once(far).state.hazard, Hazard::kOutside);
}

TEST(Safety, ASetpointThatIsNotFiniteIsNotSent) {
  for (const Setpoint& wanted :
       {Setpoint(VelocitySetpoint{{0, kNan, 0}, 0}), Setpoint(VelocitySetpoint{{0, 0, 0}, kInf}),
        Setpoint(PositionSetpoint{{kNan, 0, 0}, 0}), Setpoint(PositionSetpoint{{0, 0, 0}, kNan}),
        Setpoint(AttitudeSetpoint{kNan, 0, 0, 0.5}), Setpoint(AttitudeSetpoint{0, 0, 0, kNan}),
        Setpoint(RateSetpoint{{0, kNan, 0}, 0.5}), Setpoint(RateSetpoint{{0, 0, 0}, kInf})}) {
    Situation now = Sound();
    now.wanted = wanted;
    EXPECT_EQ(Once(now).state.hazard, Hazard::kNotFinite);
    ExpectHold(Once(now));
    ExpectSink(Later(now));
  }
}

TEST(Safety, ImageStaleItHoldsAndThenSinks) {
  for (const auto& age : {std::optional<double>(), std::optional(0.51), std::optional(kNan)}) {
    Situation now = Sound();
    now.image_age_s = age;
    EXPECT_EQ(Once(now).state.hazard, Hazard::kImageStale);
    ExpectHold(Once(now));
    ExpectSink(Later(now));
  }
}

TEST(Safety, TargetLostForTooLongItHoldsAndThenSinks) {
  Situation now = Sound();
  now.target_lost_s = kLimits.target_s;  // the flight code may still look for it
  EXPECT_EQ(Once(now).reaction, Reaction::kFly);
  now.target_lost_s += 0.01;
  EXPECT_EQ(Once(now).state.hazard, Hazard::kTargetLost);
  ExpectHold(Once(now));
  ExpectSink(Later(now));
}

TEST(Safety, OutsideTheAreaItComesBackSlowlyWhateverItsHeading) {
  for (const double yaw_deg : {0.0, 90.0, -135.0}) {
    Situation now = Sound();
    now.state.p_NB = now.start_N + Eigen::Vector3d(-24, 32, -10);
    now.state.R_NB = HeadingRotation(Radians(yaw_deg));
    const SafeCommand command = Once(now);
    EXPECT_EQ(command.state.hazard, Hazard::kOutside);
    const Eigen::Vector3d v_N = now.state.R_NB * Velocity(command).v_H;
    EXPECT_LT((v_N - kLimits.slow_m_s * Eigen::Vector3d(0.6, -0.8, 0)).norm(), 1e-12);
    EXPECT_EQ(Later(now).reaction, Reaction::kReturn);
  }
}

TEST(Safety, TooHighItComesDownAndFliesOnOtherwise) {
  Situation now = Sound();
  now.state.p_NB.z() = now.start_N.z() - 20.1;
  EXPECT_EQ(Once(now).state.hazard, Hazard::kTooHigh);
  EXPECT_EQ(Velocity(Once(now)).v_H, Eigen::Vector3d(1, -0.5, kLimits.slow_m_s));
  now.wanted = VelocitySetpoint{{0, 0, 0.9}, 0};  // faster down than it would be
  EXPECT_EQ(Velocity(Once(now)).v_H.z(), 0.9);
  now.wanted = PositionSetpoint{now.start_N, 0};
  EXPECT_EQ(Velocity(Once(now)).v_H, Eigen::Vector3d(0, 0, kLimits.slow_m_s));
}

TEST(Safety, AskedForNothingItHolds) {
  Situation now = Sound();
  now.wanted.reset();
  EXPECT_EQ(Once(now).state.hazard, Hazard::kNoSetpoint);
  ExpectHold(Once(now));
  ExpectHold(Later(now));
}

TEST(Safety, OfSeveralHazardsTheFirstRowCounts) {
  Situation now = Sound();
  now.state.p_NB.z() = now.start_N.z() - 100;
  now.image_age_s = 3;
  EXPECT_EQ(Once(now).state.hazard, Hazard::kImageStale);
  now.state_age_s = 3;
  EXPECT_EQ(Once(now).state.hazard, Hazard::kStateLost);
  now.pilot_allows = false;
  EXPECT_EQ(Once(now).state.hazard, Hazard::kPilot);
}

TEST(Safety, PatienceBeginsAnewWithEachHazard) {
  Situation now = Sound();
  now.image_age_s = 1;
  SafetyState state = MakeSafe(now, {}, kLimits).state;
  now.t_s += 9.9;
  state = MakeSafe(now, state, kLimits).state;
  Situation well = Sound();
  well.t_s = now.t_s + 0.05;
  state = MakeSafe(well, state, kLimits).state;  // one image came
  now.t_s += 0.1;
  ExpectHold(MakeSafe(now, state, kLimits));
}

TEST(Safety, SpeedsAreLimitedInTheirDirection) {
  Situation now = Sound();
  now.wanted = VelocitySetpoint{{3, 4, -5}, Radians(-400)};
  const SafeCommand command = Once(now);
  EXPECT_TRUE(command.limited);
  EXPECT_LT((Velocity(command).v_H - Eigen::Vector3d(1.2, 1.6, -1)).norm(), 1e-12);
  EXPECT_NEAR(Velocity(command).yaw_rate, Radians(-45), 1e-12);
}

TEST(Safety, PlacesAreLimitedToTheArea) {
  Situation now = Sound();
  now.wanted = PositionSetpoint{now.start_N + Eigen::Vector3d(30, 40, -100), 1};
  const SafeCommand command = Once(now);
  EXPECT_TRUE(command.limited);
  const auto& place = std::get<PositionSetpoint>(*command.setpoint);
  EXPECT_LT((place.p_N - now.start_N - Eigen::Vector3d(18, 24, -20)).norm(), 1e-12);
  EXPECT_EQ(place.yaw, 1);
}

TEST(Safety, TheTiltThatIsLimitedIsThatOfTheThrust) {
  for (const auto& [roll_deg, pitch_deg] :
       {std::pair{50.0, 0.0}, {0.0, -50.0}, {18.0, 18.0}, {-40.0, 40.0}}) {
    Situation now = Sound();
    now.wanted = AttitudeSetpoint{Radians(roll_deg), Radians(pitch_deg), 9, 0.95};
    const SafeCommand command = Once(now);
    EXPECT_TRUE(command.limited);
    const auto& s = std::get<AttitudeSetpoint>(*command.setpoint);
    const Eigen::Vector3d thrust = RotationFromTaitBryan({0.7, s.pitch, s.roll}) * Eigen::Vector3d(0, 0, -1);
    EXPECT_LE(Degrees(std::acos(-thrust.z())), 20 + 1e-9) << roll_deg << ' ' << pitch_deg;
    EXPECT_NEAR(s.yaw_rate, Radians(45), 1e-12);
    EXPECT_EQ(s.thrust, 0.8);
  }
  Situation now = Sound();
  now.wanted = AttitudeSetpoint{0.1, -0.1, 0, 0.5};
  EXPECT_FALSE(Once(now).limited);
}

TEST(Safety, RatesThatWouldTiltBeyondTheLimitAreStoppedThoseThatLeadBackAreNot) {
  int stopped = 0, let_through = 0;
  for (const double tilt_deg : {-30.0, -10.0, 10.0, 30.0}) {
    for (const double rate : {-1.0, 1.0}) {
      Situation now = Sound();
      now.state.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({0.7, 0, Radians(tilt_deg)}));
      now.wanted = RateSetpoint{{rate, 0, 9}, 0.95};
      const SafeCommand command = Once(now);
      EXPECT_TRUE(command.limited);
      const auto& s = std::get<RateSetpoint>(*command.setpoint);
      const bool farther = std::abs(tilt_deg) > 20 && tilt_deg * rate > 0;
      EXPECT_EQ(s.w_B.x(), farther ? 0 : rate) << tilt_deg << ' ' << rate;
      EXPECT_NEAR(s.w_B.z(), Radians(45), 1e-12);
      EXPECT_EQ(s.thrust, 0.8);
      ++(farther ? stopped : let_through);
    }
  }
  EXPECT_EQ(stopped, 2);
  EXPECT_EQ(let_through, 6);
}

TEST(Safety, WhateverIsAskedForOnlyWhatIsFiniteAndWithinTheLimitsIsSent) {
  const double odd[] = {0, 1, -1, 1e9, -1e9, kNan, kInf, -kInf, 1e-320};
  int sent = 0;
  for (const double a : odd)
    for (const double b : odd)
      for (const double c : odd) {
        Situation now = Sound();
        now.state.p_NB = {a, b, c};
        now.wanted = VelocitySetpoint{{b, c, a}, c};
        const SafeCommand command = Once(now);
        if (!command.setpoint) continue;
        ++sent;
        EXPECT_LE(Velocity(command).v_H.head<2>().norm(), kLimits.speed_m_s + 1e-9);
        EXPECT_LE(std::abs(Velocity(command).v_H.z()), kLimits.climb_m_s);
        EXPECT_LE(std::abs(Velocity(command).yaw_rate), Radians(kLimits.yaw_rate_deg_s));
      }
  EXPECT_EQ(sent, 9 * 9 * 9);
}

}  // namespace
}  // namespace kestrel::control
