// SPDX-License-Identifier: Apache-2.0
#include "control/law/looming.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/law/avoidance.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;

TEST(Looming, AreTheDerivativesOfTheAngleAndOfTheBearing) {
  constexpr double kStep_s = 1e-5, kRadius = 0.4;
  const Vector2d p(11, -6), v(-3, 2.5);
  const auto angle = [&](double t) { return std::asin(kRadius / (p + t * v).norm()); };
  const auto bearing = [&](double t) { return std::atan2((p + t * v).y(), (p + t * v).x()); };
  const Looming looming = LoomingOf(p, v);
  // Of a small angle.
  EXPECT_NEAR(looming.growth, (angle(kStep_s) - angle(-kStep_s)) / (2 * kStep_s) / angle(0), 1e-3);
  EXPECT_NEAR(looming.bearing_rate, (bearing(kStep_s) - bearing(-kStep_s)) / (2 * kStep_s), 1e-8);
}

TEST(Looming, TellTheClosestPointWhateverTheUnitOfLength) {
  int compared = 0;
  for (const double unit : {0.1, 1.0, 30.0})
    for (double course = 0; course < 2 * M_PI; course += 0.3) {
      const Vector2d p(20, 5), v = 4 * Vector2d(std::cos(course), std::sin(course));
      const ClosestApproach metres = ApproachOf(p, v);
      const LoomingApproach shares = ApproachOf(LoomingOf(unit * p, unit * v));
      EXPECT_NEAR(shares.after_s, metres.after_s, 1e-9);
      EXPECT_NEAR(shares.miss_share * p.norm(), metres.distance_m, 1e-9);
      ++compared;
    }
  EXPECT_EQ(compared, 63);
}

TEST(Looming, WhatStandsThereOrIsThereThreatensNobody) {
  EXPECT_EQ(ApproachOf(LoomingOf({5, 1}, {0, 0})).after_s, 0);
  EXPECT_EQ(ApproachOf(LoomingOf({0, 0}, {1, 0})).after_s, 0);
}

}  // namespace
}  // namespace kestrel::control
