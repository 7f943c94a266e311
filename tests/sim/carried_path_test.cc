// SPDX-License-Identifier: Apache-2.0
#include "sim/carried_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "tests/sim/hover.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

CarryParameters Way() { return {{{1, {2, -1, 1.5}, 10}, {3, {2, 3, 1.5}, -50}, {4, {2, 3, 1}, -50}}, {}}; }

TEST(CarriedPath, RestsAtItsPlaces) {
  const CarriedPath path(Way(), 1);
  for (const auto& [t_s, place, yaw_deg] : {std::tuple{0.0, Vector3d(2, -1, -1.5), 10.0},
                                            {1.0, Vector3d(2, -1, -1.5), 10.0},
                                            {3.0, Vector3d(2, 3, -1.5), -50.0},
                                            {4.0, Vector3d(2, 3, -1), -50.0},
                                            {9.0, Vector3d(2, 3, -1), -50.0}}) {
    const Pose X_NB = path.X_NB(t_s);
    EXPECT_LT((X_NB.p - place).norm(), 1e-12) << t_s;
    EXPECT_NEAR(Degrees(YawOf(X_NB.R)), yaw_deg, 1e-9) << t_s;
    constexpr double kStep_s = 1e-4;  // the speed grows with the square of the time from a place
    EXPECT_LT((path.X_NB(t_s + kStep_s).p - path.X_NB(t_s - kStep_s).p).norm() / (2 * kStep_s), 1e-4) << t_s;
  }
}

// Of the least jerk between two rests a distance d and a time T apart the greatest speed is 15/8 d/T, in the
// middle.
TEST(CarriedPath, GoesWithTheLeastJerk) {
  const CarriedPath path(Way(), 1);
  EXPECT_LT((path.X_NB(2).p - Vector3d(2, 1, -1.5)).norm(), 1e-12);
  double fastest = 0;
  constexpr double kStep_s = 1e-3;
  for (double t_s = 1; t_s < 3; t_s += kStep_s)
    fastest = std::max(fastest, (path.X_NB(t_s + kStep_s).p - path.X_NB(t_s).p).norm() / kStep_s);
  EXPECT_NEAR(fastest, 15.0 / 8 * 4 / 2, 1e-4);
}

TEST(CarriedPath, TremblesAsMuchAsItIsTold) {
  CarryParameters way = Way();
  way.points.resize(1);
  way.tremor = {{.from_hz = 8, .until_hz = 12, .rms_deg = 0.2, .rms_mm = 3}};
  const CarriedPath path(way, 4), other(way, 5);
  const Pose still = CarriedPath(Way(), 1).X_NB(0);
  double place = 0, turn = 0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const Pose off = still.Inverse() * path.X_NB(0.005 * i);
    place += off.p.squaredNorm() / 3 / kSamples,
        turn += std::pow(LogRotation(off.R).norm(), 2) / 3 / kSamples;
  }
  EXPECT_NEAR(1e3 * std::sqrt(place), 3, 0.3);
  EXPECT_NEAR(Degrees(std::sqrt(turn)), 0.2, 0.02);
  EXPECT_GT((path.X_NB(1).p - other.X_NB(1).p).norm(), 1e-5);
}

TEST(CarriedPath, WhatCannotBeGoneIsRefusedAtOnce) {
  CarryParameters way{{{2, {0, 0, 1}, 0}, {2, {0, 0, 0}, 0}}, {{.from_hz = 9, .until_hz = 3}}};
  Mistakes mistakes;
  CheckCarry(way, "f.yaml", mistakes);
  EXPECT_THAT(mistakes.Texts(), ::testing::ElementsAre(::testing::HasSubstr("carry.points[1].t_s"),
                                                       ::testing::HasSubstr("carry.points[1].position_m"),
                                                       ::testing::HasSubstr("carry.tremor")));
  Mistakes none;
  CheckCarry({}, "f.yaml", none);
  EXPECT_THAT(none.Texts(), ::testing::ElementsAre(::testing::HasSubstr("carry.points")));
  Mistakes right;
  CheckCarry(Way(), "f.yaml", right);
  EXPECT_TRUE(right.Texts().empty());
}

TEST(CarriedPath, IsWhereTheSimulatedAircraftIsWithItsVelocity) {
  SimulatorParameters p = Hover();
  p.start.settle_s = 0;
  p.duration_s = 2.2;
  p.image.rate_hz = 10;
  p.camera = vision::Pinhole{16, 16, 20, 20, 7.5, 7.5};
  p.carry = Way();
  p.carry->tremor = {{.from_hz = 1, .until_hz = 3, .rms_deg = 1, .rms_mm = 5}};
  Simulator simulator(p);
  const CarriedPath path(*p.carry, p.seed);
  int frames = 0;
  while (simulator.Next()) {
    ++frames;
    const Truth& truth = simulator.exposure();
    const Pose X_NB = path.X_NB(truth.t_s);
    EXPECT_LT((truth.X_NB.p - X_NB.p).norm(), 1e-9);
    EXPECT_LT(truth.X_NB.R.angularDistance(X_NB.R), 1e-7);
    constexpr double kStep_s = 1e-5;
    const Pose later = path.X_NB(truth.t_s + kStep_s);
    EXPECT_LT((truth.v_N - (later.p - X_NB.p) / kStep_s).norm(), 2e-3);
    EXPECT_LT((truth.w_B - LogRotation(X_NB.R.conjugate() * later.R) / kStep_s).norm(), 2e-3);
  }
  EXPECT_GE(frames, 20);
  EXPECT_EQ(simulator.State().mode, control::FlightMode::kStopped);
}

}  // namespace
}  // namespace kestrel::sim
