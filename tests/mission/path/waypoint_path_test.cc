// SPDX-License-Identifier: Apache-2.0
#include "mission/path/waypoint_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

using Eigen::Vector3d;

const PathParameters kParameters{.speed_m_s = 2,
                                 .acceleration_m_s2 = 0.5,
                                 .yaw_rate_deg_s = 20,
                                 .yaw_acceleration_deg_s2 = 10,
                                 .lambda_per_s = 0.5};

WaypointPath Rectangle() {
  return WaypointPath({{{0, 0, -5}, 0, 2, "hold"},
                       {{20, 0, -5}, 0, 0, "line"},
                       {{20, 3, -5}, 0, 1, "side"},
                       {{20, 3, -5}, 2 * std::numbers::pi, 1, "turn"}},
                      kParameters);
}

TEST(WaypointPath, TakesTheTimesOfTrapezoids) {
  const WaypointPath path = Rectangle();
  EXPECT_DOUBLE_EQ(path.arrival_s(0), 0);
  EXPECT_DOUBLE_EQ(path.arrival_s(1), 2 + 20.0 / 2 + 2 / 0.5);  // length / speed + one ramp
  EXPECT_DOUBLE_EQ(path.arrival_s(2), path.arrival_s(1) + 2 * std::sqrt(3 / 0.5));  // too short to cruise
  EXPECT_NEAR(path.arrival_s(3), path.arrival_s(2) + 1 + 360.0 / 20 + 20.0 / 10, 1e-9);
  EXPECT_DOUBLE_EQ(path.duration_s(), path.arrival_s(3) + 1);
}

TEST(WaypointPath, VelocitiesAreTheDerivativesOfPlaces) {
  const WaypointPath path = Rectangle();
  constexpr double kStep_s = 1e-5;
  int moving = 0;
  for (double t = 0.0137; t < path.duration_s() + 1; t += 0.05) {
    const auto before = path.At(t - kStep_s), now = path.At(t), after = path.At(t + kStep_s);
    EXPECT_LT(((after.p_N - before.p_N) / (2 * kStep_s) - now.v_N).norm(), 1e-5) << t;
    EXPECT_NEAR((after.yaw - before.yaw) / (2 * kStep_s), now.yaw_rate, 1e-5) << t;
    moving += now.v_N.norm() > 0.1 || now.yaw_rate > 0.1;
  }
  EXPECT_GT(moving, 400);
}

TEST(WaypointPath, KeepsToSpeedAndAcceleration) {
  const WaypointPath path = Rectangle();
  double fastest = 0, hardest = 0;
  for (double t = 0; t < path.duration_s(); t += 0.01) {
    fastest = std::max(fastest, path.At(t).v_N.norm());
    hardest = std::max(hardest, (path.At(t + 0.01).v_N - path.At(t).v_N).norm() / 0.01);
  }
  EXPECT_NEAR(fastest, 2, 1e-9);
  EXPECT_LE(hardest, 0.5 + 1e-6);
}

TEST(WaypointPath, PassesItsWaypointsAndStaysAtTheLast) {
  const WaypointPath path = Rectangle();
  for (std::size_t i = 0; i < path.waypoints().size(); ++i) {
    const auto there = path.At(path.arrival_s(i));
    EXPECT_LT((there.p_N - path.waypoints()[i].p_N).norm(), 1e-9) << i;
    EXPECT_NEAR(there.yaw, path.waypoints()[i].yaw, 1e-9) << i;
  }
  EXPECT_EQ(path.At(1e6).p_N, path.waypoints().back().p_N);
  EXPECT_EQ(path.At(1e6).v_N.norm(), 0);
  EXPECT_EQ(path.At(1).waypoint, 0u);
  EXPECT_EQ(path.At(3).waypoint, 1u);
  EXPECT_EQ(path.At(1e6).waypoint, 3u);
}

// An aircraft that does what it is told comes to the path, whatever its yaw.
TEST(FollowPath, ComesToThePathFromBesideIt) {
  const WaypointPath path = Rectangle();
  control::VehicleState state;
  state.p_NB = {1, -2, -4};
  double yaw = Radians(-140);
  constexpr double kStep_s = 0.02;
  for (double t = 0; t < path.duration_s(); t += kStep_s) {
    state.R_NB = HeadingRotation(yaw);
    const control::VelocitySetpoint setpoint = FollowPath(path.At(t), state, kParameters);
    state.p_NB += kStep_s * (HeadingRotation(yaw) * setpoint.v_H);
    yaw += kStep_s * setpoint.yaw_rate;
  }
  EXPECT_LT((state.p_NB - Vector3d(20, 3, -5)).norm(), 0.02);
  EXPECT_NEAR(WrapAngle(yaw), 0, 0.02);
}

TEST(FollowPath, AsksForNoMoreThanTwiceThePathsOwn) {
  const WaypointPath path = Rectangle();
  control::VehicleState state;
  state.p_NB = {1000, 500, 300};
  state.R_NB = HeadingRotation(3);
  const control::VelocitySetpoint setpoint = FollowPath(path.At(5), state, kParameters);
  EXPECT_NEAR(setpoint.v_H.head<2>().norm(), 4, 1e-9);
  EXPECT_NEAR(setpoint.v_H.z(), -4, 1e-9);
  EXPECT_NEAR(std::abs(setpoint.yaw_rate), Radians(40), 1e-9);
}

}  // namespace
}  // namespace kestrel::mission
