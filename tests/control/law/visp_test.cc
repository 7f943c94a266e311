// SPDX-License-Identifier: Apache-2.0
// ViSP 3.5 as a second source: the velocities must be its own to 1e-9 for the same features, depths and gain.
#include "tests/visp/visp.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "control/law/pbvs.h"
#include "control/law/point_servo.h"
#include "geometry/pose.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kLambda = 0.73;
constexpr double kTolerance = 1e-9;

Eigen::VectorXd Vector(const Twist& twist) {
  Eigen::VectorXd v(6);
  v << twist.v, twist.w;
  return v;
}

Pose RandomPose(std::mt19937& rng, double angle) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> u(0, 1);
  const Vector3d axis = Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
  return {ExpRotation(angle * u(rng) * axis), 0.3 * Vector3d(normal(rng), normal(rng), normal(rng))};
}

// Points before the camera, as (x, y, Z); in every second set a planar square.
std::vector<Vector3d> Seen(const Pose& X_CT, int set) {
  std::vector<Vector3d> points;
  for (const Vector3d& p : {Vector3d(-0.4, -0.4, 0), {0.4, -0.4, 0}, {0.4, 0.4, 0}, {-0.4, 0.4, 0}}) {
    const double out = set % 2 == 0 ? 0 : 0.3 * p.x() + 0.7 * p.y() * p.x();
    const Vector3d p_C = X_CT * (p + Vector3d(0, 0, out));
    points.push_back({p_C.x() / p_C.z(), p_C.y() / p_C.z(), p_C.z()});
  }
  return points;
}

std::vector<ImagePoint> Ours(const std::vector<Vector3d>& points) {
  std::vector<ImagePoint> ours;
  for (const Vector3d& p : points) ours.push_back({p.head<2>(), p.z()});
  return ours;
}

TEST(Visp, GivesPointsTheSameMatrixAndVelocityWithEveryChoiceOfMatrix) {
  std::mt19937 rng(21);
  int checked = 0;
  for (int set = 0; set < 60; ++set) {
    const Pose ahead{Eigen::Quaterniond::Identity(), {0, 0, 2.5}};
    const std::vector<Vector3d> now = Seen(ahead * RandomPose(rng, 1.0), set),
                                wanted = Seen(ahead * RandomPose(rng, 0.4), set);
    for (const Vector3d& p : now) {
      EXPECT_LT((visp::PointInteraction(p) - PointInteraction(p.head<2>(), p.z())).norm(), kTolerance);
    }
    for (const auto& [ours, theirs] : {std::pair{InteractionChoice::kCurrent, visp::Matrix::kCurrent},
                                       {InteractionChoice::kDesired, visp::Matrix::kDesired},
                                       {InteractionChoice::kMean, visp::Matrix::kMean}}) {
      const Eigen::VectorXd velocity = visp::PointVelocity(now, wanted, theirs, kLambda);
      const ServoStep step = PointServo(Ours(now), Ours(wanted), ours, kLambda);
      ASSERT_EQ(step.state, ServoState::kRegular);
      ASSERT_GT(velocity.norm(), 0.01);
      EXPECT_LT((step.velocity - velocity).norm(), kTolerance) << set;
      ++checked;
    }
  }
  EXPECT_EQ(checked, 180);
}

TEST(Visp, GivesBothLawsOnPosesTheSameVelocity) {
  std::mt19937 rng(22);
  for (int i = 0; i < 100; ++i) {
    const Pose X_DC = RandomPose(rng, 3.0);
    const Pose X_DO = Pose{Eigen::Quaterniond::Identity(), {0, 0, 2}} * RandomPose(rng, 1.0);
    const Pose X_CO = X_DC.Inverse() * X_DO;
    EXPECT_LT((Vector(PbvsTwist(X_DC, kLambda)) - visp::PoseVelocity(X_DC, kLambda)).norm(), kTolerance);
    EXPECT_LT(
        (Vector(PbvsTargetTwist(X_CO, X_DO, kLambda)) - visp::TargetPoseVelocity(X_CO, X_DO, kLambda)).norm(),
        kTolerance);
    EXPECT_LT((RotationVectorInteraction(LogRotation(X_DC.R)) - visp::ThetaUInteraction(X_DC).rightCols<3>())
                  .norm(),
              kTolerance);
  }
}

}  // namespace
}  // namespace kestrel::control
