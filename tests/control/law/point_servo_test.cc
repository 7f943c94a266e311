// SPDX-License-Identifier: Apache-2.0
#include "control/law/point_servo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/pose.h"
#include "tests/control/law/numeric_interaction.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<ImagePoint> Square(const Pose& X_CT, double half_m) {
  std::vector<ImagePoint> points;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Vector3d p = X_CT * Vector3d(x * half_m, y * half_m, 0);
    points.push_back({p.head<2>() / p.z(), p.z()});
  }
  return points;
}

Pose Ahead(double distance_m, const Vector3d& turn = Vector3d::Zero(),
           const Vector3d& aside = Vector3d::Zero()) {
  return {ExpRotation(turn), Vector3d(0, 0, distance_m) + aside};
}

double Error(const std::vector<ImagePoint>& now, const std::vector<ImagePoint>& wanted) {
  double square = 0;
  for (std::size_t i = 0; i < now.size(); ++i) square += (now[i].s - wanted[i].s).squaredNorm();
  return std::sqrt(square);
}

TEST(PointInteraction, IsTheDerivativeByItsDefinition) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const double Z = 3 + 2.5 * u(rng);
    const Vector3d p(1.5 * Z * u(rng), 1.5 * Z * u(rng), Z);
    const Eigen::MatrixXd numeric =
        NumericInteraction([](const Vector3d& q) -> Vector2d { return q.head<2>() / q.z(); }, p);
    const Eigen::MatrixXd L = PointInteraction(Vector2d(p.head<2>() / Z), Z);
    EXPECT_LT((L - numeric).norm(), 1e-8 * L.norm());
  }
}

TEST(PointInteraction, OfSeveralStacksThemInTheirOrder) {
  const std::vector<ImagePoint> points = {{{0.1, 0.2}, 1.5}, {{-0.3, 0.4}, 2}, {{0.5, -0.6}, 2.5}};
  const Eigen::MatrixXd L = PointInteraction(points);
  ASSERT_EQ(L.rows(), 6);
  for (int i = 0; i < 3; ++i) {
    const ImagePoint& p = points[static_cast<std::size_t>(i)];
    EXPECT_EQ((L.middleRows<2>(2 * i)), PointInteraction(p.s, p.Z));
  }
}

TEST(PointServo, TheErrorOfThreePointsFallsExponentiallyWithTheCurrentMatrix) {
  // As many equations as unknowns: every error can be met at every instant.
  const std::vector<ImagePoint> four = Square(Ahead(2), 0.3), wanted(four.begin(), four.begin() + 3);
  const Pose X_CT = Ahead(2.4, {0.1, -0.2, 0.3}, {0.2, -0.1, 0});
  const std::vector<ImagePoint> all = Square(X_CT, 0.3), now(all.begin(), all.begin() + 3);
  const ServoStep step = PointServo(now, wanted, InteractionChoice::kCurrent, 0.7);
  ASSERT_EQ(step.state, ServoState::kRegular);
  EXPECT_NEAR(step.reach, 1, 1e-9);
  const double dt = 1e-5;
  const Pose X_CD{ExpRotation(dt * step.velocity.tail<3>()), dt * step.velocity.head<3>()};
  const std::vector<ImagePoint> next = Square(X_CD.Inverse() * X_CT, 0.3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2d rate = (next[i].s - now[i].s) / dt;
    EXPECT_LT((rate + 0.7 * (now[i].s - wanted[i].s)).norm(), 1e-5);  // the step's curvature
  }
}

TEST(PointServo, EveryChoiceOfMatrixGoesHomeFromNearby) {
  const std::vector<ImagePoint> wanted = Square(Ahead(1.5), 0.25);
  for (const auto choice :
       {InteractionChoice::kCurrent, InteractionChoice::kDesired, InteractionChoice::kMean}) {
    Pose X_CT = Ahead(1.9, {0.15, -0.1, 0.4}, {0.2, 0.1, 0});
    double before = Error(Square(X_CT, 0.25), wanted);
    for (int i = 0; i < 400; ++i) {
      const ServoStep step = PointServo(Square(X_CT, 0.25), wanted, choice, 1);
      ASSERT_EQ(step.state, ServoState::kRegular);
      const Twist twist = TwistOf(step);
      X_CT = Pose{ExpRotation(0.02 * twist.w), 0.02 * twist.v}.Inverse() * X_CT;
      const double after = Error(Square(X_CT, 0.25), wanted);
      ASSERT_LT(after, before);
      before = after;
    }
    EXPECT_LT(before, 1e-3);
    EXPECT_LT((X_CT.p - Vector3d(0, 0, 1.5)).norm(), 1e-2);
  }
}

TEST(PointServo, HalfATurnIsASingularityOfTheMeanMatrixAndSaysSo) {
  const std::vector<ImagePoint> wanted = Square(Ahead(2), 0.3),
                                now = Square(Ahead(2, {0, 0, std::numbers::pi}), 0.3);
  const ServoStep step = PointServo(now, wanted, InteractionChoice::kMean, 1);
  EXPECT_EQ(step.state, ServoState::kSingular);
  EXPECT_LT(step.reach, 1e-6);  // a stand-still
  EXPECT_LT(step.velocity.norm(), 1e-6);
  // The current matrix flies straight back, the desired one straight on: Chaumette's conundrum.
  const ServoStep back = PointServo(now, wanted, InteractionChoice::kCurrent, 1);
  EXPECT_LT(back.velocity[2], -1);
  EXPECT_LT((back.velocity - back.velocity[2] * Eigen::VectorXd::Unit(6, 2)).norm(), 1e-9);
  const ServoStep on = PointServo(now, wanted, InteractionChoice::kDesired, 1);
  EXPECT_NEAR(on.velocity[2], -back.velocity[2], 1e-9);
}

TEST(PointServo, ThreePointsSeenFromTheirCylinderAreSingularAndDampingBoundsTheVelocityThere) {
  // the right circular cylinder on the circle through the points
  std::vector<ImagePoint> now, wanted;
  for (const double angle : {0.0, 2.1, 4.2}) {
    const Vector3d p =
        Vector3d(std::cos(angle), std::sin(angle), 2) - Vector3d(std::cos(1.0), std::sin(1.0), 0);
    now.push_back({p.head<2>() / p.z(), p.z()});
    wanted.push_back({now.back().s + Vector2d(0.05 * std::cos(3 * angle), 0.04), 2});
  }
  const ServoStep step = PointServo(now, wanted, InteractionChoice::kCurrent, 1);
  EXPECT_EQ(step.state, ServoState::kSingular);
  EXPECT_EQ(step.rank, 5);
  // and a hair's breadth beside it
  now[0].s.x() += 1e-4;
  const ServoStep wild = PointServo(now, wanted, InteractionChoice::kCurrent, 1),
                  tame = PointServo(now, wanted, InteractionChoice::kCurrent, 1, {.damping = 0.01});
  EXPECT_EQ(wild.state, ServoState::kRegular);
  EXPECT_GT(wild.velocity.norm(), 20 * tame.velocity.norm());
  EXPECT_GT(tame.velocity.norm(), 0.01);
}

TEST(PointServo, WhatCannotBeServedHasANameAndNoVelocity) {
  const std::vector<ImagePoint> wanted = Square(Ahead(2), 0.3);
  const auto state = [&](std::vector<ImagePoint> now, InteractionChoice choice) {
    const ServoStep step = PointServo(now, wanted, choice, 1);
    EXPECT_EQ(step.state == ServoState::kRegular, step.velocity.norm() > 0);
    return step.state;
  };
  const std::vector<ImagePoint> near = Square(Ahead(2.2), 0.3);
  std::vector<ImagePoint> behind = near, unknown = near, gone = near;
  behind[2].Z = -1;
  unknown[1].Z = 0;
  gone[3].s.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(state(behind, InteractionChoice::kCurrent), ServoState::kDepthNotPositive);
  EXPECT_EQ(state(unknown, InteractionChoice::kMean), ServoState::kDepthNotPositive);
  EXPECT_EQ(state(unknown, InteractionChoice::kDesired), ServoState::kRegular);
  EXPECT_EQ(state(gone, InteractionChoice::kDesired), ServoState::kNotFinite);
  EXPECT_EQ(PointServo({}, {}, InteractionChoice::kMean, 1).state, ServoState::kNoFeatures);
  EXPECT_STREQ(NameOf(ServoState::kDepthNotPositive), "depth not positive");
}

}  // namespace
}  // namespace kestrel::control
