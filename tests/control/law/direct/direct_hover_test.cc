// SPDX-License-Identifier: Apache-2.0
#include "control/law/direct/direct_hover.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const DirectGains kGains;

TEST(DirectHover, OverItsGoalItHoversLevelAndDoesNotTurn) {
  for (const double yaw : {0.0, 2.0}) {
    const RateSetpoint s = DirectHover({}, HeadingRotation(yaw), kGains);
    EXPECT_LT(s.w_B.norm(), 1e-9);
    EXPECT_NEAR(s.thrust, kGains.hover_thrust, 1e-12);
    EXPECT_LT(ThrustAcceleration(s.thrust, HeadingRotation(yaw), kGains).norm(), 1e-12);
  }
}

TEST(DirectHover, TurnsTowardsTheAccelerationThatItWantsWhateverTheHeading) {
  for (const double yaw : {0.0, 1.0, -2.5}) {
    const Quaterniond R_NB = HeadingRotation(yaw);
    const DirectError error{.p_N = {0.2, -0.1, 0}};
    const RateSetpoint s = DirectHover(error, R_NB, kGains);
    // After a moment at those rates the thrust pushes back towards the goal.
    const Vector3d a = ThrustAcceleration(s.thrust, R_NB * ExpRotation(0.1 * s.w_B), kGains);
    EXPECT_LT(a.head<2>().normalized().dot(error.p_N.head<2>().normalized()), -0.999) << yaw;
    EXPECT_EQ(s.w_B.z(), 0);
  }
}

TEST(DirectHover, HoldsAgainstTheDisturbance) {
  // At the attitude and thrust at which it no longer turns, what they give is the disturbance's opposite.
  const DirectError error{.d_N = {0.8, -0.5, 0.3}};
  Quaterniond R_NB = Quaterniond::Identity();
  for (int k = 0; k < 400; ++k) R_NB = R_NB * ExpRotation(0.01 * DirectHover(error, R_NB, kGains).w_B);
  const RateSetpoint s = DirectHover(error, R_NB, kGains);
  EXPECT_LT(s.w_B.norm(), 1e-6);
  EXPECT_LT((ThrustAcceleration(s.thrust, R_NB, kGains) + error.d_N).norm(), 1e-6);
}

// What is asked for at the limit stands still at the speed k_p / k_v times it.
TEST(DirectHover, ComesFromAfarAtALimitedSpeed) {
  const double speed = kGains.position_per_s2 * kGains.offset_limit_m / kGains.velocity_per_s;
  const DirectError far{.p_N = {20, 0, 20}, .v_N = {-speed, 0, -speed}};
  const RateSetpoint s = DirectHover(far, Quaterniond::Identity(), kGains);
  EXPECT_LT(s.w_B.norm(), 1e-9);
  EXPECT_NEAR(s.thrust, kGains.hover_thrust, 1e-9);
}

TEST(DirectHover, KeepsItsLimits) {
  const DirectError far{.p_N = {100, 0, -100}, .yaw = 3};
  const RateSetpoint s = DirectHover(far, ExpRotation({0.3, -0.2, 1}), kGains);
  EXPECT_LE(s.w_B.head<2>().norm(), Radians(kGains.rate_limit_deg_s) + 1e-9);
  EXPECT_NEAR(s.w_B.z(), Radians(kGains.yaw_rate_limit_deg_s), 1e-12);
  EXPECT_GE(s.thrust, 0);
  EXPECT_LE(s.thrust, 1);
}

// Rigid body, rates followed at once, thrust exact: the loop without delays settles.
TEST(DirectHover, SettlesInAClosedLoop) {
  Vector3d p(0.6, -0.4, 0.3), v = Vector3d::Zero();
  const Vector3d d(0.4, 0, 0.2);
  Quaterniond R_NB = HeadingRotation(0.7);
  double yaw = 0.5;
  constexpr double kDt = 0.01;
  for (int k = 0; k < 600; ++k) {
    const RateSetpoint s = DirectHover({p, v, d, yaw}, R_NB, kGains);
    const Vector3d a = ThrustAcceleration(s.thrust, R_NB, kGains) + d;
    p += kDt * v, v += kDt * a;
    yaw -= kDt * s.w_B.z();
    R_NB = R_NB * ExpRotation(kDt * s.w_B);
  }
  EXPECT_LT(p.norm(), 1e-2);
  EXPECT_LT(std::abs(yaw), 1e-3);
}

}  // namespace
}  // namespace kestrel::control
