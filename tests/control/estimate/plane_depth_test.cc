// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/plane_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace kestrel::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Four points on the ground under a camera at a place, exactly or by noise.
std::vector<Vector2d> Seen(const Vector3d& p, std::mt19937* rng = nullptr) {
  std::vector<Vector2d> points;
  std::normal_distribution<double> noise(0, 3e-4);
  for (const auto& [x, y] : {std::pair{0.6, 0.4}, {0.6, -0.4}, {-0.6, -0.4}, {-0.6, 0.4}}) {
    Vector2d s = (Vector2d(x, y) - p.head<2>()) / -p.z();
    if (rng) s += Vector2d(noise(*rng), noise(*rng));
    points.push_back(s);
  }
  return points;
}

TEST(PlaneDepth, LearnsTheDepthFromItsOwnWay) {
  for (const Vector3d& v : {Vector3d(0.4, 0.1, 0), Vector3d(0, 0, 0.3), Vector3d(-0.2, 0.2, -0.2)}) {
    PlaneDepth depth({.depth_m = 3});
    Vector3d p(0.1, -0.2, -5);
    constexpr double kDt = 0.05;
    for (int k = 0; k < 120; ++k) {
      depth.Add(k * kDt, Seen(p), v);
      if (k < 119) p += kDt * v;
    }
    // Straight down the points of a small target move little: it learns more slowly, and says so.
    const bool aside = v.head<2>().norm() > 0;
    EXPECT_NEAR(depth.depth_m(), -p.z(), (aside ? 0.03 : 0.1) * -p.z());
    EXPECT_LT(depth.sigma_m(), aside ? 0.6 : 1.3);
  }
}

TEST(PlaneDepth, ErrsByNoMoreThanItSays) {
  std::mt19937 rng(8);
  std::normal_distribution<double> noise;
  double square = 0;
  int within = 0;
  constexpr int kFlights = 100;
  for (int flight = 0; flight < kFlights; ++flight) {
    PlaneDepth depth({.depth_m = 3});
    Vector3d p(0, 0, -4);
    const Vector3d error = 0.03 * Vector3d(noise(rng), noise(rng), noise(rng));
    for (int k = 0; k < 200; ++k) {
      const Vector3d v(0.5 * std::cos(0.05 * k), 0.5 * std::sin(0.07 * k), 0.1 * std::sin(0.03 * k));
      depth.Add(k * 0.05, Seen(p, &rng), v + error);
      p += 0.05 * v;
    }
    const double off = std::abs(depth.depth_m() + p.z());
    square += off * off;
    within += off < 3 * depth.sigma_m();
  }
  EXPECT_LT(std::sqrt(square / kFlights), 0.25);
  EXPECT_GE(within, 95);
}

TEST(PlaneDepth, StandingStillItKeepsWhatItHasAndKnowsLess) {
  PlaneDepth depth({.depth_m = 3});
  const double before = depth.sigma_m();
  for (int k = 0; k < 200; ++k) depth.Add(k * 0.05, Seen({0, 0, -5}), Vector3d::Zero());
  EXPECT_EQ(depth.depth_m(), 3);
  EXPECT_GE(depth.sigma_m(), before);
}

TEST(PlaneDepth, AGapOrOtherPointsAreNotTakenForAWay) {
  PlaneDepth depth({.depth_m = 3});
  depth.Add(0, Seen({0, 0, -5}), {1, 0, 0});
  depth.Add(2, Seen({0, 0, -5}), {1, 0, 0});  // two metres by its reckoning, none by the image
  EXPECT_EQ(depth.depth_m(), 3);
}

}  // namespace
}  // namespace kestrel::control
