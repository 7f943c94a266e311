// SPDX-License-Identifier: Apache-2.0
#include "mission/ground/clock_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kestrel::mission {
namespace {

// An aircraft that swings by half a metre, measured with a clock that is ahead by so much, against a navigation that
// is off by a constant.
ClockOffset Watched(double offset_s, double swing_m, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.03);
  const auto at = [&](double t) {
    return Eigen::Vector3d(swing_m * std::sin(1.3 * t), swing_m * std::cos(0.7 * t), -3);
  };
  const auto velocity = [&](double t) {
    return Eigen::Vector3d(1.3 * swing_m * std::cos(1.3 * t), -0.7 * swing_m * std::sin(0.7 * t), 0);
  };
  ClockOffset clock;
  for (int i = 0; i < 600; ++i) {
    const double stamp = i / 30.0;
    const Eigen::Vector3d measured =
        at(stamp - offset_s) + Eigen::Vector3d(noise(random), noise(random), noise(random));
    clock.Add(stamp, measured, at(stamp) + Eigen::Vector3d(0.8, -0.4, 0.3), velocity(stamp));
  }
  return clock;
}

TEST(ClockOffset, IsFoundFromAnAircraftThatMoves) {
  for (const double offset_s : {-0.15, 0.0, 0.08, 0.3}) {
    const auto found = Watched(offset_s, 0.5).Get();
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->offset_s, offset_s, 0.02) << offset_s;
    EXPECT_LT(found->sigma_s, 0.03);
  }
}

TEST(ClockOffset, IsApartOnlyBeyondDoubt) {
  EXPECT_FALSE(Watched(0, 0.5).Apart(0.04));
  EXPECT_FALSE(Watched(0.03, 0.5).Apart(0.04));
  EXPECT_TRUE(Watched(0.2, 0.5).Apart(0.04));
  EXPECT_TRUE(Watched(-0.2, 0.5).Apart(0.04));
}

TEST(ClockOffset, IsTogetherOnlyWhereThatIsLikely) {
  EXPECT_TRUE(Watched(0, 0.5).Together(0.04));
  EXPECT_FALSE(Watched(0.03, 0.5).Together(0.04));
  EXPECT_FALSE(Watched(0.2, 0.5).Together(0.04));
}

TEST(ClockOffset, ANavigationThatWandersWhileTheAircraftSinksIsNoClock) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.03);
  ClockOffset clock;
  for (int i = 0; i < 300; ++i) {
    const double t = i / 30.0, gust = 0.06 * std::sin(2 * t);
    const double sink = t < 1 ? 0 : 0.5;
    const Eigen::Vector3d p(0.03 * (1 - std::cos(2 * t)), 0, -5 + 0.5 * std::max(0.0, t - 1));
    const Eigen::Vector3d wander(0.2 * std::sin(0.3 * t), 0, -0.02 * t);
    clock.Add(t, p + Eigen::Vector3d(noise(random), noise(random), noise(random)), p + wander,
              {gust, 0, sink});
    EXPECT_FALSE(clock.Apart(0.04)) << t;
  }
}

TEST(ClockOffset, SaysNothingOfAnAircraftThatStands) {
  EXPECT_FALSE(Watched(0.3, 0.02).Get());
  EXPECT_FALSE(Watched(0.3, 0.02).Apart(0.04));
  EXPECT_FALSE(Watched(0, 0.02).Together(0.04));
}

}  // namespace
}  // namespace kestrel::mission
