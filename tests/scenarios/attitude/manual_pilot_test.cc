// SPDX-License-Identifier: Apache-2.0
#include "scenarios/attitude/manual_pilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

// A point that leans at once as the stick says, with air's drag; thrust 0.55 carries it.
struct Flown {
  double farthest_m = 0, height_error_m = 0, max_roll = 0, max_pitch = 0, turned = 0;
};
Flown FlyFor(double seconds, const ManoeuvreParameters& p, std::uint64_t seed) {
  ManualPilot pilot(p, seed);
  control::VehicleState s;
  s.p_NB = {0, 0, -p.height_m};
  double yaw = 0;
  Flown flown;
  constexpr double kStep_s = 0.05;
  for (s.t_s = 0; s.t_s < seconds; s.t_s += kStep_s) {
    const control::AttitudeSetpoint stick = pilot.Fly(s, Eigen::Vector3d::Zero());
    yaw += stick.yaw_rate * kStep_s;
    s.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({yaw, stick.pitch, stick.roll}));
    const Eigen::Vector3d a = Eigen::Vector3d(0, 0, 9.80665) -
                              stick.thrust / 0.55 * 9.80665 * (s.R_NB * Eigen::Vector3d::UnitZ()) -
                              0.25 * s.v_N;
    s.v_N += kStep_s * a;
    s.p_NB += kStep_s * s.v_N;
    flown.farthest_m = std::max(flown.farthest_m, s.p_NB.head<2>().norm());
    if (s.t_s > 10) flown.height_error_m = std::max(flown.height_error_m, std::abs(s.p_NB.z() + p.height_m));
    flown.max_roll = std::max(flown.max_roll, std::abs(stick.roll));
    flown.max_pitch = std::max(flown.max_pitch, std::abs(stick.pitch));
    flown.turned = std::max(flown.turned, std::abs(yaw));
  }
  return flown;
}

TEST(ManualPilot, ThrowsTheAircraftAboutAndKeepsItNear) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Flown f = FlyFor(90, {}, seed);
    EXPECT_GT(f.max_roll, Radians(25)) << seed;
    EXPECT_GT(f.max_pitch, Radians(25)) << seed;
    EXPECT_LE(std::max(f.max_roll, f.max_pitch), Radians(30) + 1e-12) << seed;
    EXPECT_GT(f.turned, Radians(360)) << seed;
    EXPECT_LT(f.farthest_m, 40) << seed;
    EXPECT_LT(f.height_error_m, 5 + 4) << seed;  // the swing that is asked for, and its own error
  }
}

TEST(ManualPilot, TheSeedIsItsMood) {
  control::VehicleState s;
  s.t_s = 7;
  const auto first = [&](std::uint64_t seed) { return ManualPilot({}, seed).Fly(s, {0, 0, 0}).roll; };
  EXPECT_EQ(first(1), first(1));
  EXPECT_NE(first(1), first(2));
}

}  // namespace
}  // namespace kestrel::scenarios
