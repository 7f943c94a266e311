// SPDX-License-Identifier: Apache-2.0
// Each law for an aircraft of four freedoms: by its definition, by ViSP, and closed over a camera that moves.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "control/law/level/hybrid_servo.h"
#include "control/law/level/level_image_servo.h"
#include "control/law/level/level_servo.h"
#include "control/law/level/partitioned_servo.h"
#include "control/law/level_camera.h"
#include "control/law/pbvs.h"
#include "geometry/tait_bryan.h"
#include "tests/control/law/numeric_interaction.h"
#include "tests/visp/visp.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Points = std::vector<ImagePoint>;

constexpr double kLambda = 0.7;
const Vector3d kDown = Vector3d::UnitZ();

// The camera looks down; T: the middle of a square on the ground, z down too.
Points Square(const Pose& X_TV) {
  Points points;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Vector3d p = X_TV.Inverse() * Vector3d(x * 0.45, y * 0.3, 0);
    points.push_back({p.head<2>() / p.z(), p.z()});
  }
  return points;
}
std::vector<BearingPoint> Bearings(const Points& points) {
  std::vector<BearingPoint> bearings;
  for (const ImagePoint& p : points) {
    const Vector3d q = p.Z * p.s.homogeneous();
    bearings.push_back({q.normalized(), q.norm()});
  }
  return bearings;
}
Pose Over(double x, double y, double height_m, double yaw_deg) {
  return {HeadingRotation(Radians(yaw_deg)), {x, y, -height_m}};
}
Pose Moved(const Pose& X_TV, const LevelTwist& twist, double dt_s) {
  return {HeadingRotation(YawOf(X_TV.R) + twist.yaw_rate * dt_s), X_TV.p + dt_s * (X_TV.R * twist.v)};
}

const Pose kGoal = Over(0, 0, 3, 0);

using Law = std::function<LevelTwist(const Pose& X_TV)>;
Law ByPoints(InteractionChoice choice) {
  return [=](const Pose& X_TV) {
    return LevelTwistOf(LevelPointServo(Square(X_TV), Square(kGoal), choice, kDown, kLambda));
  };
}
struct NamedLaw {
  const char* name;
  Law law;
};
std::vector<NamedLaw> Laws() {
  return {
      {"points, current", ByPoints(InteractionChoice::kCurrent)},
      {"points, desired", ByPoints(InteractionChoice::kDesired)},
      {"points, mean", ByPoints(InteractionChoice::kMean)},
      {"bearings",
       [](const Pose& X) {
         return LevelTwistOf(LevelBearingServo(Bearings(Square(X)), Bearings(Square(kGoal)),
                                               InteractionChoice::kCurrent, kDown, kLambda));
       }},
      {"hybrid",
       [](const Pose& X) {
         return LevelTwistOf(
             HybridTwist(Square(X)[0], Square(kGoal)[0], LogRotation((kGoal.Inverse() * X).R), kLambda),
             kDown);
       }},
      {"partitioned", [](const Pose& X) { return PartitionedTwist(Square(X), Square(kGoal), kLambda); }},
      {"level image", [](const Pose& X) { return LevelImageTwist(Square(X), Square(kGoal), kLambda); }},
  };
}

struct End {
  double off_m = 0, off_deg = 0, highest_m = 0, lowest_m = 1e9;
};
End Fly(const Law& law, Pose X_TV, double duration_s = 30) {
  constexpr double kStep_s = 0.02;
  End end;
  for (double t = 0; t < duration_s; t += kStep_s) {
    X_TV = Moved(X_TV, law(X_TV), kStep_s);
    end.highest_m = std::max(end.highest_m, -X_TV.p.z());
    end.lowest_m = std::min(end.lowest_m, -X_TV.p.z());
    if (end.highest_m > 300 || end.lowest_m < 0.05) break;
  }
  end.off_m = (X_TV.p - kGoal.p).norm(), end.off_deg = Degrees(std::abs(YawOf(X_TV.R)));
  return end;
}

TEST(LevelLaws, EachEndsAtItsGoalFromAnOffsetATurnAndAnotherHeight) {
  for (const auto& [name, law] : Laws()) {
    for (const Pose& start : {Over(0.8, -0.6, 3, 0), Over(0, 0, 5, 0), Over(0, 0, 1.5, 0), Over(0, 0, 3, 70),
                              Over(-0.5, 0.4, 4.5, -60)}) {
      const End end = Fly(law, start);
      EXPECT_LT(end.off_m, 1e-3) << name;
      EXPECT_LT(end.off_deg, 0.1) << name;
    }
  }
}

// Chaumette, "Potential problems of stability and convergence", 1998; Corke and Hutchinson, 2001.
TEST(LevelLaws, HalfATurnEndsAsTheoryHasIt) {
  for (const auto& [name, law] : Laws()) {
    const End end = Fly(law, Over(0, 0, 3, 180));
    const std::string_view which = name;
    if (which == "points, current" || which == "bearings") {
      EXPECT_GT(end.highest_m, 50) << name;  // retreats for ever
    } else if (which == "points, desired") {
      EXPECT_LT(end.lowest_m, 0.1) << name;  // comes down through the target
    } else if (which == "points, mean") {
      EXPECT_NEAR(end.off_deg, 180, 0.1);  // stands still: the matrix is singular
      EXPECT_LT(end.off_m, 0.1);
    } else {
      EXPECT_LT(end.off_m, 1e-3) << name;
      EXPECT_LT(end.off_deg, 0.1) << name;
      EXPECT_LT(end.highest_m, 3.01) << name;
    }
  }
}

TEST(LevelPointServo, IsTheLawOfSixWhereNoTurnButYawIsAsked) {
  // Its four columns are ViSP's matrix without those of roll and pitch.
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 50; ++i) {
    const Points now = Square(Over(u(rng), u(rng), 3 + u(rng), 60 * u(rng)));
    Eigen::MatrixXd L(8, 4);
    Eigen::VectorXd e(8);
    for (int k = 0; k < 4; ++k) {
      const ImagePoint& p = now[static_cast<std::size_t>(k)];
      const Eigen::MatrixXd whole = visp::PointInteraction({p.s.x(), p.s.y(), p.Z});
      L.middleRows<2>(2 * k) << whole.leftCols<3>(), whole.col(5);
      e.segment<2>(2 * k) = p.s - Square(kGoal)[static_cast<std::size_t>(k)].s;
    }
    const Eigen::VectorXd expected = -kLambda * L.colPivHouseholderQr().solve(e);
    const ServoStep step = LevelPointServo(now, Square(kGoal), InteractionChoice::kCurrent, kDown, kLambda);
    ASSERT_EQ(step.state, ServoState::kRegular);
    EXPECT_LT((step.velocity - expected).norm(), 1e-9);
  }
}

TEST(LevelPointServo, APointBehindTheCameraIsAStateAndNoVelocity) {
  Points now = Square(kGoal);
  now[2].Z = -1;
  const ServoStep step = LevelPointServo(now, Square(kGoal), InteractionChoice::kCurrent, kDown, kLambda);
  EXPECT_EQ(step.state, ServoState::kDepthNotPositive);
  EXPECT_EQ(LevelTwistOf(step).v, Vector3d::Zero());
}

TEST(HybridServo, ItsMatrixIsTheDerivativeByItsDefinition) {
  const Vector3d p(0.7, -0.4, 2.3);
  const Eigen::MatrixXd numeric = NumericInteraction(
      [](const Vector3d& q) { return Vector3d(q.x() / q.z(), q.y() / q.z(), std::log(q.z())); }, p);
  EXPECT_LT((DepthPointInteraction(p.head<2>() / p.z(), p.z()) - numeric).norm(), 1e-8);
}

TEST(HybridServo, GivesTheVelocityOfViSP) {
  std::mt19937 rng(5);
  std::normal_distribution<double> n;
  for (int i = 0; i < 100; ++i) {
    const Pose X_DC{ExpRotation(Vector3d(n(rng), n(rng), n(rng))), {0, 0, 0}};
    const ImagePoint now{{0.3 * n(rng), 0.3 * n(rng)}, 2 + std::abs(n(rng))}, wanted{{0.1, -0.2}, 2.5};
    const Twist twist = HybridTwist(now, wanted, LogRotation(X_DC.R), kLambda);
    Eigen::VectorXd ours(6);
    ours << twist.v, twist.w;
    const Eigen::VectorXd theirs = visp::HybridVelocity(
        {now.s.x(), now.s.y(), now.Z}, {wanted.s.x(), wanted.s.y(), wanted.Z}, X_DC, kLambda);
    ASSERT_GT(theirs.norm(), 0.01);
    EXPECT_LT((ours - theirs).norm(), 1e-9) << i;
  }
}

TEST(PartitionedServo, SizeAndAngleMoveAsTheLawReckons) {
  const Points now = Square(Over(0.2, -0.3, 4, 25));
  constexpr double kSmall = 1e-6;
  const auto after = [](const LevelTwist& twist) {
    const Pose X = Over(0.2, -0.3, 4, 25);
    return PolygonImageOf(Square(Moved(X, twist, kSmall)));
  };
  const PolygonImage at = PolygonImageOf(now);
  EXPECT_NEAR((after({{0, 0, 1}, 0}).size - at.size) / kSmall, at.size / 4, 1e-5);
  EXPECT_NEAR((after({{0, 0, 0}, 1}).angle - at.angle) / kSmall, -1, 1e-5);
  EXPECT_NEAR((after({{1, 0, 0}, 0}).size - at.size) / kSmall, 0, 1e-6);
  EXPECT_NEAR((after({{0, 1, 0}, 0}).angle - at.angle) / kSmall, 0, 1e-6);
  EXPECT_NEAR(at.size, std::sqrt(0.9 * 0.6) / 4, 1e-12);  // by the square itself
}

TEST(PartitionedServo, WhatTheAxisDoesToThePointsIsNotUndoneByTheRest) {
  // A turn about the axis over the middle asks for nothing aside.
  const LevelTwist twist = PartitionedTwist(Square(Over(0, 0, 3, 120)), Square(kGoal), kLambda);
  EXPECT_NEAR(twist.yaw_rate, -kLambda * Radians(120), 1e-12);
  EXPECT_LT(twist.v.norm(), 1e-12);
}

TEST(LevelImageServo, ItsFeaturesAndTheirMatrixAreViSPs) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> u(-1, 1);
  const Points wanted = Square(kGoal);
  double area = 0;  // about the centroid, which is the middle
  for (const ImagePoint& p : wanted) area += p.s.squaredNorm();
  for (int i = 0; i < 50; ++i) {
    const double height_m = 3 + 2 * u(rng);
    const Points now = Square(Over(u(rng), u(rng), height_m, 180 * u(rng)));
    std::vector<Vector2d> points;
    for (const ImagePoint& p : now) points.push_back(p.s);
    const visp::Moments theirs = visp::NormalisedMoments(points, height_m, area, 3);
    const LevelImage ours = LevelImageOf(now, wanted);
    EXPECT_LT((3 * ours.q - theirs.value).norm(), 1e-9);
    Eigen::MatrixXd columns(3, 4);
    columns << theirs.interaction.leftCols<3>(), theirs.interaction.col(5);
    EXPECT_LT((3 * LevelImageInteraction(ours.q, 3) - columns).norm(), 1e-9) << i;
  }
}

TEST(LevelImageServo, KnowsEachTurnAndTheTurnIsNoneOfTheDirectionOfTheView) {
  for (const double yaw_deg : {-170.0, -90.0, 0.0, 45.0, 180.0}) {
    const LevelImage image = LevelImageOf(Square(Over(0.4, 0.1, 2, yaw_deg)), Square(kGoal));
    EXPECT_NEAR(WrapAngle(image.angle + Radians(yaw_deg)), 0, 1e-9);
  }
}

TEST(LevelImageServo, TheErrorsFallAsOneExponential) {
  // As in the pose-based law (5.11), of which the twist is the same: the place of the target as it is seen.
  const Pose X_TV = Over(0.7, -0.4, 4, 50);
  const LevelTwist image = LevelImageTwist(Square(X_TV), Square(kGoal), kLambda);
  const Twist pose = PbvsTargetTwist(X_TV.Inverse(), kGoal.Inverse(), kLambda);
  EXPECT_LT((image.v - pose.v).norm(), 1e-12);
  EXPECT_NEAR(image.yaw_rate, pose.w.z(), 1e-12);
}

}  // namespace
}  // namespace kestrel::control
