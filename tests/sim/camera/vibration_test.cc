// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

TEST(Vibration, AStillMountIsStill) {
  const Vibration none({}, 1), silent({vision::VibrationBand{}}, 1);
  for (const Vibration* v : {&none, &silent}) {
    EXPECT_TRUE(v->still());
    EXPECT_TRUE(v->At(0.123).p.isZero(0));
    EXPECT_EQ(v->At(0.123).R.angularDistance(Eigen::Quaterniond::Identity()), 0);
  }
}

TEST(Vibration, HasItsRootMeanSquareOnEachAxis) {
  const Vibration v({{20, 40, 0.3, 0.5}, {90, 110, 0.4, 0}}, 3);
  Eigen::Vector3d turns = Eigen::Vector3d::Zero(), ways = turns;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const Pose X = v.At(0.0013 * i);
    turns += LogRotation(X.R).cwiseAbs2() / kCount, ways += X.p.cwiseAbs2() / kCount;
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(Degrees(std::sqrt(turns[axis])), 0.5, 0.02) << axis;  // 0.3 and 0.4 at a right angle
    EXPECT_NEAR(1e3 * std::sqrt(ways[axis]), 0.5, 0.02) << axis;
  }
}

TEST(Vibration, KeepsToItsBand) {
  const Vibration v({{60, 80, 0, 1}}, 5);
  EXPECT_GE(v.highest_hz(), 60);
  EXPECT_LE(v.highest_hz(), 80);
  // the share of the power in 10 s that the frequencies of the band hold
  constexpr int kCount = 4000;
  constexpr double kDt = 0.0025;
  std::vector<double> way(kCount);
  double all = 0, inside = 0;
  for (int i = 0; i < kCount; ++i) {
    way[i] = v.At(i * kDt).p.y() * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / kCount));
    all += way[i] * way[i];
  }
  for (int f = 595; f <= 805; ++f) {
    std::complex<double> sum;
    for (int i = 0; i < kCount; ++i)
      sum += way[i] * std::polar(1.0, -2 * std::numbers::pi * (f * static_cast<long>(i) % kCount) / kCount);
    inside += 2 * std::norm(sum) / kCount;  // and as much at the negative frequency
  }
  EXPECT_GT(inside, 0.999 * all);
}

TEST(Vibration, SeedAloneDecides) {
  const std::vector<vision::VibrationBand> bands = {{80, 120, 0.2, 0.1}};
  const Vibration a(bands, 1), again(bands, 1), other(bands, 2);
  EXPECT_EQ(a.At(1.5).p, again.At(1.5).p);
  EXPECT_NE(a.At(1.5).p, other.At(1.5).p);
  EXPECT_NE(a.At(1.5).p, a.At(1.501).p);
  EXPECT_NE(a.At(1.5).p.x(), a.At(1.5).p.y());
}

}  // namespace
}  // namespace kestrel::sim
