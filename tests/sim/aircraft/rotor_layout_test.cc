// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "sim/aircraft/multirotor.h"
#include "sim/aircraft/multirotor_shape.h"
#include "sim/gltf/scene_glb.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

MultirotorParameters Ring(int count, double first_deg, double arm_m = 0.25) {
  MultirotorParameters p;
  for (int i = 0; i < count; ++i) {
    const double bearing = (first_deg + 360.0 * i / count) * M_PI / 180;
    p.rotors.push_back(
        {arm_m * std::cos(bearing), arm_m * std::sin(bearing), i % 2 ? "counterclockwise" : "clockwise"});
  }
  return p;
}

std::pair<double, Vector3d> Given(const MultirotorParameters& p, const RotorSpeeds& speeds) {
  RotorSpeeds high;
  high.fill(std::numeric_limits<double>::infinity());
  const Wrench w = AerodynamicWrench(p, speeds, Vector3d::Zero(), Vector3d::Zero(), high);
  return {-w.force.z(), w.torque};
}

TEST(RotorLayout, AListedPlusFliesAsTheOneThatIsNotListed) {
  const MultirotorParameters plus;
  MultirotorParameters listed = Ring(4, 0, plus.arm_m);
  std::mt19937 rng{91};
  std::uniform_real_distribution<double> unit(-1, 1);
  int limited = 0;
  for (int i = 0; i < 2000; ++i) {
    const double thrust = 14 + 20 * unit(rng);
    const Vector3d torque(3 * unit(rng), 3 * unit(rng), 0.5 * unit(rng));
    const RotorSpeeds a = Allocate(plus, thrust, torque), b = Allocate(listed, thrust, torque);
    for (std::size_t r = 0; r < 4; ++r) {
      ASSERT_NEAR(a[r] * a[r], b[r] * b[r], 1e-5 * 838 * 838) << i;
      limited += a[r] > 837.999;
    }
    for (std::size_t r = 4; r < kMaxRotors; ++r) ASSERT_EQ(b[r], 0);
  }
  EXPECT_GT(limited, 100);
}

TEST(RotorLayout, EachGivesBackWhatWasAskedAndKeepsRollAndPitchFirst) {
  std::mt19937 rng{17};
  std::uniform_real_distribution<double> unit(-1, 1);
  int cases = 0;
  for (const auto& [count, first_deg] :
       {std::pair{4, 45.0}, {6, 0.0}, {6, 30.0}, {8, 0.0}, {8, 22.5}, {12, 15.0}}) {
    MultirotorParameters p = Ring(count, first_deg);
    p.rotors.front().x_m *= 0.9;  // not even
    for (int i = 0; i < 200; ++i, ++cases) {
      const double thrust = 3.2 * count * (1 + 0.2 * unit(rng));
      const Vector3d torque(0.4 * unit(rng), 0.4 * unit(rng), 0.03 * unit(rng));
      const auto [given, turned] = Given(p, Allocate(p, thrust, torque));
      ASSERT_NEAR(given, thrust, 1e-9) << count;
      ASSERT_LT((turned - torque).norm(), 1e-9) << count;
      // a thrust and a yaw that nothing can give leave roll and pitch as they are
      const Vector3d greedy(torque.x(), torque.y(), 5);
      const auto [full, kept] = Given(p, Allocate(p, 1000, greedy));
      ASSERT_LT((kept - greedy).head<2>().norm(), 1e-9) << count;
      ASSERT_LT(full, count * LimitsOf(p.rotor).thrust_n);
      // what is out of reach keeps its direction
      const auto [some, turn] = Given(p, Allocate(p, thrust, 100 * torque));
      ASSERT_NEAR(turn.x() * torque.y(), turn.y() * torque.x(), 1e-9);
      ASSERT_GT(turn.head<2>().dot(torque.head<2>()), 0);
    }
  }
  EXPECT_EQ(cases, 6 * 200);
}

TEST(RotorLayout, WhatCannotFlyIsToldWhy) {
  const double weight = 12;
  const auto why = [&](const MultirotorParameters& p) {
    return CannotFly(LayoutOf(p), LimitsOf(p.rotor), weight).value_or("flies");
  };
  for (const int count : {4, 6, 8, 12}) EXPECT_EQ(why(Ring(count, 10)), "flies") << count;
  EXPECT_THAT(why(Ring(3, 0)), HasSubstr("has 3, and thrust, roll, pitch and yaw take four"));

  MultirotorParameters one_spin = Ring(4, 0);
  for (RotorPlace& each : one_spin.rotors) each.spin = "clockwise";
  EXPECT_THAT(why(one_spin), HasSubstr("thrust and yaw cannot be had alone"));

  MultirotorParameters beam = Ring(4, 0);
  for (RotorPlace& each : beam.rotors) each.y_m = 0;
  EXPECT_THAT(why(beam), HasSubstr("roll cannot be had alone"));

  MultirotorParameters ahead = Ring(4, 45);
  for (RotorPlace& each : ahead.rotors) each.x_m += 0.3;
  EXPECT_THAT(why(ahead), HasSubstr("would have to push down"));

  MultirotorParameters weak = Ring(4, 45);
  weak.rotor.max_speed_rad_s = 550;
  EXPECT_THAT(why(weak), HasSubstr("carries 3 N in a level hover"));
}

TEST(RotorLayout, IsDrawnAsItIs) {
  const MultirotorParameters p = Ring(6, 30);
  const std::string shape = MultirotorShape(p);
  for (int i = 1; i <= 6; ++i) EXPECT_THAT(shape, HasSubstr("vehicle_rotor_" + std::to_string(i) + '"'));
  EXPECT_THAT(shape, testing::Not(HasSubstr("vehicle_rotor_7")));
  // the second from the front right is on the right: in the fragment y is left and z up
  EXPECT_NEAR(p.rotors[1].y_m, 0.25, 1e-12);
  const std::size_t second = shape.find("vehicle_rotor_2\""), y = shape.find("pos=\"", second);
  EXPECT_NEAR(std::stod(shape.substr(shape.find(' ', y) + 1)), -0.25, 1e-5);
  EXPECT_EQ(SeenRotors(p).size(), 6u);
}

}  // namespace
}  // namespace kestrel::sim
