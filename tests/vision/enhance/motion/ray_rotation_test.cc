// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/ray_rotation.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "geometry/pose.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector3d;

Vector3d AnyDirection(RandomStream& random) {
  return Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
}

TEST(FitRotationTest, IsTheOneThatTurnsThem) {
  RandomStream random(4, "test");
  for (int i = 0; i < 20; ++i) {
    const Eigen::Quaterniond R = ExpRotation(2 * AnyDirection(random));
    std::vector<RayPair> pairs;
    for (int k = 0; k < 5; ++k) {
      const Vector3d from = AnyDirection(random);
      pairs.push_back({from, R * from});
    }
    const auto fit = FitRotation(pairs);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->angularDistance(R), 1e-7);
  }
  EXPECT_FALSE(FitRotation(std::vector<RayPair>(1)));
  EXPECT_FALSE(FitRotation(std::vector<RayPair>(3, {Vector3d::UnitX(), Vector3d::UnitY()})));
}

TEST(FitRotationTest, IsFoundAmongOutliers) {
  RandomStream random(5, "test");
  const Eigen::Quaterniond R = ExpRotation(Vector3d(0.2, -0.4, 0.1));
  std::vector<RayPair> pairs;
  for (int k = 0; k < 60; ++k) {
    const Vector3d from = AnyDirection(random);
    pairs.push_back({from, k % 3 == 0 ? AnyDirection(random) : Vector3d(R * from)});
  }
  const auto fit = FitRobustRotation(pairs, 1e-3, 20);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->R.angularDistance(R), 1e-7);
  EXPECT_GE(fit->inliers.size(), 40U);
  EXPECT_FALSE(FitRobustRotation(pairs, 1e-3, 50));
}

}  // namespace
}  // namespace kestrel::vision
