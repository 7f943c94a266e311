// SPDX-License-Identifier: Apache-2.0
#include "sim/world/target.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;
constexpr double kStep_s = 0.002;

TEST(Target, WithAVelocityItLeavesItsPlaceAtTimeZero) {
  TargetPath path({.position_m = {3, 4, 5}, .velocity_m_s = {1, -2, 0.5}}, 1, 0);
  path.Step(-1, kStep_s, {9, 9, 9});
  EXPECT_EQ(path.p_N(), Vector3d(3, 4, -5));
  path.Step(2, kStep_s, {9, 9, 9});
  EXPECT_TRUE(path.p_N().isApprox(Vector3d(5, 0, -6)));
  EXPECT_TRUE(path.v_N().isApprox(Vector3d(1, -2, -0.5)));
}

// Drag over net lift, both by hand: 1/2 rho C_D pi r^2 u^2, and six tenths of the weight of the displaced
// air.
TEST(Target, OnItsStringItLeansByDragOverLift) {
  const double r = 0.25, wind = 3;
  TargetPath path({.diameter_m = 2 * r, .position_m = {0, 0, 4}, .string_m = 1.5}, 1, 0);
  for (int i = 0; i < 20000; ++i) path.Step(0.002 * i, kStep_s, {0, wind, 0});
  const double drag = 0.5 * 1.225 * 0.47 * std::numbers::pi * r * r * wind * wind;
  const double lift = 0.6 * 1.225 * 4.0 / 3 * std::numbers::pi * r * r * r * 9.80665;
  const Vector3d string = path.p_N() - path.anchor_N();
  EXPECT_NEAR(std::atan2(string.y(), -string.z()), std::atan2(drag, lift), 1e-6);
  EXPECT_NEAR(string.norm(), r + 1.5, 1e-12);
  EXPECT_NEAR(path.v_N().norm(), 0, 1e-6);
}

// Without wind: small oscillations of period 2 pi sqrt(L m / F), of all the mass that moves, hardly damped.
TEST(Target, OnItsStringItSwingsAsAPendulum) {
  TargetPath path({.diameter_m = 0.5, .position_m = {0, 0, 8}, .string_m = 5.75}, 1, 0);
  for (int i = 0; i < 100; ++i) path.Step(0, kStep_s, {3, 0, 0});  // a push
  std::vector<double> crossings;
  double last = path.p_N().x();
  for (int i = 0; i < 30000; ++i) {
    path.Step(0, kStep_s, Vector3d::Zero());
    if (last < 0 && path.p_N().x() >= 0) crossings.push_back(kStep_s * i);
    last = path.p_N().x();
  }
  ASSERT_GE(crossings.size(), 3u);
  const double expected = 2 * std::numbers::pi * std::sqrt(6.0 * 0.9 / (0.6 * 9.80665));
  EXPECT_NEAR(crossings[2] - crossings[1], expected, 0.01 * expected);
}

TEST(Target, RoamingIsSmoothFastEnoughAndStaysNear) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TargetPath path({.position_m = {10, 0, 4}, .roam_m_s = 2, .roam_within_m = 8}, seed, 0);
    double fastest = 0, farthest = 0, lowest = 1e9, acceleration = 0, stopped_s = 0;
    Vector3d v = Vector3d::Zero();
    for (int i = 1; i < 60000; ++i) {
      path.Step(kStep_s * i, kStep_s, Vector3d::Zero());
      acceleration = std::max(acceleration, (path.v_N() - v).norm() / kStep_s);
      v = path.v_N();
      fastest = std::max(fastest, v.norm());
      stopped_s += v.norm() < 1e-3 ? kStep_s : 0;
      farthest = std::max(farthest, (path.p_N() - Vector3d(10, 0, -4)).head<2>().norm());
      lowest = std::min(lowest, -path.p_N().z());
    }
    EXPECT_GT(fastest, 1.4);
    EXPECT_LE(fastest, 2 + 1e-9);
    EXPECT_LE(acceleration, 1.5 + 1e-6);
    EXPECT_LT(farthest, 8 + 16);
    EXPECT_GT(lowest, 0.5);
    EXPECT_GT(stopped_s, 0.5);
  }
}

TEST(Target, ASeedIsAPathAndEachTargetHasItsOwn) {
  const TargetParameters roaming{.roam_m_s = 1};
  TargetPath a(roaming, 7, 0), same(roaming, 7, 0), other(roaming, 7, 1), later(roaming, 8, 0);
  for (int i = 1; i < 5000; ++i)
    for (TargetPath* path : {&a, &same, &other, &later}) path->Step(kStep_s * i, kStep_s, Vector3d::Zero());
  EXPECT_EQ(a.p_N(), same.p_N());
  EXPECT_NE(a.p_N(), other.p_N());
  EXPECT_NE(a.p_N(), later.p_N());
}

}  // namespace
}  // namespace kestrel::sim
