// SPDX-License-Identifier: Apache-2.0
#include "control/law/bearing_servo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/pose.h"
#include "tests/control/law/numeric_interaction.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d RandomBearing(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
}

TEST(SpherePoint, OfABearingLeadsBackToItAndAheadRightAndDownAreWhatTheyAreCalled) {
  std::mt19937 rng(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3d s = RandomBearing(rng);
    EXPECT_LT((BearingOf(SpherePointOf(s)) - s).norm(), 1e-14);
  }
  EXPECT_NEAR(SpherePointOf({1, 0, 0}).azimuth, 0, 1e-15);
  EXPECT_NEAR(SpherePointOf({0, 1, 0}).azimuth, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(SpherePointOf({-1, -1, 0}).azimuth, -0.75 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(SpherePointOf({0, 0, 1}).colatitude, 0, 1e-15);
  EXPECT_NEAR(SpherePointOf({1, 0, -1}).colatitude, 0.75 * std::numbers::pi, 1e-15);
}

TEST(SpherePointInteraction, IsTheDerivativeByItsDefinition) {
  std::mt19937 rng(8);
  std::uniform_real_distribution<double> range(0.5, 6);
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d s = RandomBearing(rng);
    // Towards the poles the azimuth's third derivative grows as 1 / sin^3 colatitude.
    if (std::hypot(s.x(), s.y()) < 0.1) continue;
    // The azimuth is measured from the bearing's own: no cut within reach.
    const double cut = SpherePointOf(s).azimuth;
    const Eigen::Quaterniond turn = ExpRotation({0, 0, -cut});
    const auto feature = [&](const Vector3d& q) -> Vector2d {
      const SpherePoint p = SpherePointOf(q);
      return {p.colatitude, SpherePointOf(turn * q).azimuth + cut};
    };
    const double L = range(rng);
    const Eigen::MatrixXd numeric = NumericInteraction(feature, L * s);
    const auto J = SpherePointInteraction(SpherePointOf(s), L);
    ASSERT_TRUE(J);
    EXPECT_LT((*J - numeric).norm(), 1e-6 * J->norm());
    ++checked;
  }
  EXPECT_GT(checked, 280);
}

TEST(SpherePointInteraction, HasNoneAtThePoles) {
  EXPECT_FALSE(SpherePointInteraction({0, 0.4}, 2));
  EXPECT_FALSE(SpherePointInteraction({std::numbers::pi, 0.4}, 2));
  EXPECT_TRUE(SpherePointInteraction({1e-3, 0.4}, 2));
}

TEST(BearingInteraction, IsTheDerivativeByItsDefinitionAtThePolesToo) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> range(0.5, 6);
  for (int i = 0; i < 206; ++i) {
    const Vector3d s = i < 6 ? Vector3d((i < 3 ? 1 : -1) * Vector3d::Unit(i % 3)) : RandomBearing(rng);
    const double L = range(rng);
    const Eigen::MatrixXd numeric =
        NumericInteraction([](const Vector3d& q) -> Vector3d { return q.normalized(); }, L* s);
    const Eigen::MatrixXd J = BearingInteraction(s, L);
    EXPECT_LT((J - numeric).norm(), 1e-8 * J.norm());
  }
}

std::vector<BearingPoint> Around(const Pose& X_CT) {
  std::vector<BearingPoint> points;
  for (const Vector3d& p_TQ :
       {Vector3d(2, 0, 0.5), {-0.5, 1.5, 0}, {-1, -1.2, 0.3}, {0.3, 0.2, 1.8}, {0.1, -0.4, -2}}) {
    const Vector3d p = X_CT * p_TQ;
    points.push_back({p.normalized(), p.norm()});
  }
  return points;
}

TEST(BearingServo, GoesHomeAmongPointsAllAroundTheCamera) {
  const std::vector<BearingPoint> wanted = Around({});
  for (const auto choice :
       {InteractionChoice::kCurrent, InteractionChoice::kDesired, InteractionChoice::kMean}) {
    Pose X_CT{ExpRotation({0.3, -0.4, 0.9}), {0.3, 0.2, -0.3}};
    for (int i = 0; i < 1000; ++i) {
      const ServoStep step = BearingServo(Around(X_CT), wanted, choice, 1);
      ASSERT_EQ(step.state, ServoState::kRegular);
      const Twist twist = TwistOf(step);
      X_CT = Pose{ExpRotation(0.02 * twist.w), 0.02 * twist.v}.Inverse() * X_CT;
    }
    EXPECT_LT(X_CT.p.norm(), 1e-4);
    EXPECT_LT(LogRotation(X_CT.R).norm(), 1e-4);
  }
}

TEST(BearingServo, WithoutADistanceItStandsStill) {
  std::vector<BearingPoint> points = Around({});
  points[1].L = 0;
  const ServoStep step = BearingServo(points, Around({}), InteractionChoice::kCurrent, 1);
  EXPECT_EQ(step.state, ServoState::kDepthNotPositive);
  EXPECT_EQ(step.velocity, Eigen::VectorXd::Zero(6));
}

}  // namespace
}  // namespace kestrel::control
