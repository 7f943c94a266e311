// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/tilt_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  Vector3d Vector(double sigma) { return {sigma * Normal(), sigma * Normal(), sigma * Normal()}; }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
};

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// A pose of a pad below, whose position and tilt are as tightly bound as a camera far above binds them.
Pose PoseBelow(Random& random) {
  return {ExpRotation(random.Vector(0.3)), Vector3d(0, 0, 4) + random.Vector(0.5)};
}

Matrix6 BoundCovariance(Random& random, double scale) {
  Matrix6 L;
  for (int i = 0; i < 36; ++i) L(i / 6, i % 6) = scale * random.Normal();
  return L * L.transpose();
}

TEST(TiltAlignment, ChangesNothingBeforeItHasSeenThePad) {
  const Vector3d down = Vector3d(0.1, -0.2, 1).normalized();
  EXPECT_LT((TiltAlignment(TiltAlignment::Options{}).Apply(down) - down).norm(), 1e-15);
}

TEST(TiltAlignment, LearnsTheOffsetOfTheAutopilot) {
  Random random(1);
  const TiltAlignment::Options options{
      .initial_deg = 1.5, .drift_deg_per_root_s = 0, .autopilot_noise_deg = 0.15};
  const Vector3d offset(Radians(0.9), Radians(-0.6), 0);
  const Matrix3d covariance = std::pow(Radians(0.5), 2) * Matrix3d::Identity();
  TiltAlignment tilt(options);
  for (int i = 0; i < 400; ++i) {
    const Vector3d down = Vector3d(0.1 * random.Normal(), 0.1 * random.Normal(), 1).normalized();
    const Vector3d noise(Radians(0.5) * random.Normal(), Radians(0.5) * random.Normal(), 0);
    tilt.Correct(0, down, ExpRotation(offset + noise) * down, covariance);
  }
  const Vector3d down = Vector3d(-0.1, 0.15, 1).normalized();
  EXPECT_LT(AngleBetween(tilt.Apply(down), ExpRotation(offset) * down), Radians(0.1));
  EXPECT_GT(AngleBetween(down, ExpRotation(offset) * down), Radians(1));
}

TEST(TiltAlignment, WeighsWhatItSeesAsTheBatchSolutionDoes) {
  Random random(2);
  const double initial = Radians(2), noise = Radians(0.15);
  TiltAlignment tilt({.initial_deg = 2, .drift_deg_per_root_s = 0, .autopilot_noise_deg = 0.15});
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity() / (initial * initial);
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector2d seen(Radians(1) * random.Normal(), Radians(1) * random.Normal());
    const Eigen::Matrix2d L = Radians(0.4) * (Eigen::Matrix2d() << 1, 0, 0.5 * random.Normal(), 1).finished();
    Matrix3d covariance = Matrix3d::Identity();
    covariance.topLeftCorner<2, 2>() = L * L.transpose();
    const Vector3d turn(seen.x(), seen.y(), 0);
    tilt.Correct(0, Vector3d::UnitZ(), ExpRotation(turn) * Vector3d::UnitZ(), covariance);
    const Eigen::Matrix2d R = L * L.transpose() + noise * noise * Eigen::Matrix2d::Identity();
    information += R.inverse();
    weighted += R.inverse() * seen;
  }
  const Eigen::Vector2d offset = information.inverse() * weighted;
  const Vector3d expected = ExpRotation({offset.x(), offset.y(), 0}) * Vector3d::UnitZ();
  EXPECT_LT((tilt.Apply(Vector3d::UnitZ()) - expected).norm(), 1e-10);
  EXPECT_NEAR(tilt.sigma(), std::sqrt(information.inverse().trace() / 2 + noise * noise), 1e-12);
}

TEST(TiltAlignment, GrowsUncertainAsTimePasses) {
  TiltAlignment tilt({.initial_deg = 1, .drift_deg_per_root_s = 0.5, .autopilot_noise_deg = 0});
  tilt.Predict(4);
  tilt.Predict(12);
  EXPECT_NEAR(tilt.sigma(), Radians(std::sqrt(1 + 0.25 * 16)), 1e-12);
}

// The linearised problem in information form: the normal moves by w x n under a small turn w.
TEST(FuseNormal, IsTheLeastSquaresSolution) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose X_CT = PoseBelow(random);
    const Matrix6 P = BoundCovariance(random, 1e-3);
    const double sigma = 1e-3;
    const Vector3d n = X_CT.R * Vector3d::UnitZ();
    const Vector3d measured = ExpRotation(random.Vector(1e-3)) * n;
    Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
    H.rightCols<3>() = -Skew(n);
    const Matrix6 fused_P = (P.inverse() + H.transpose() * H / (sigma * sigma)).inverse();
    const Vector6 step = fused_P * H.transpose() * (measured - n) / (sigma * sigma);

    Pose fused = X_CT;
    Matrix6 covariance = P;
    FuseNormal(measured, sigma, fused, covariance);
    Vector6 moved;
    moved << fused.p - X_CT.p, LogRotation(fused.R * X_CT.R.conjugate());
    EXPECT_LT((moved - step).norm(), 1e-3 * step.norm() + 1e-8) << i;
    EXPECT_LT((covariance - fused_P).norm(), 1e-8 * P.norm()) << i;
    EXPECT_EQ(covariance, covariance.transpose());
  }
}

TEST(FuseNormal, TakesAnExactNormalAndLeavesAWorthlessOne) {
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Pose X_CT = PoseBelow(random);
    const Vector3d measured = ExpRotation(random.Vector(5e-3)) * (X_CT.R * Vector3d::UnitZ());
    Pose fused = X_CT;
    Matrix6 covariance = 1e-4 * Matrix6::Identity();
    FuseNormal(measured, 1e-9, fused, covariance);
    EXPECT_LT(AngleBetween(fused.R * Vector3d::UnitZ(), measured), 1e-8);
    EXPECT_LT((fused.p - X_CT.p).norm(), 1e-12);  // not bound to the tilt here

    fused = X_CT;
    covariance = BoundCovariance(random, 1e-3);
    const Matrix6 before = covariance;
    FuseNormal(measured, 1e3, fused, covariance);
    EXPECT_LT((fused.p - X_CT.p).norm(), 1e-9);
    EXPECT_LT((covariance - before).norm(), 1e-9 * before.norm());
  }
}

TEST(FuseNormal, MendsThePositionBoundToTheTilt) {
  Random random(5);
  constexpr int kDraws = 1000;
  const Pose truth{ExpRotation({0.1, -0.2, 0.7}), {0.4, -0.3, 5}};
  // a tilt by w moves the position by about w x p, as where only the direction to the pad is well known
  Matrix6 L = Matrix6::Zero();
  L.bottomRightCorner<3, 3>() = Radians(1) * Matrix3d::Identity();
  L.topRightCorner<3, 3>() = -Skew(truth.p) * L.bottomRightCorner<3, 3>();
  L.topLeftCorner<3, 3>() = 0.01 * Matrix3d::Identity();
  const double sigma = Radians(0.1);
  double before = 0, after = 0, nees = 0;
  for (int i = 0; i < kDraws; ++i) {
    Vector6 unit;
    unit << random.Vector(1), random.Vector(1);
    const Vector6 error = L * unit;
    Pose X_CT{ExpRotation(error.tail<3>()) * truth.R, truth.p + error.head<3>()};
    before += (X_CT.p - truth.p).head<2>().squaredNorm() / kDraws;
    Matrix6 covariance = L * L.transpose();
    FuseNormal(ExpRotation(random.Vector(sigma)) * (truth.R * Vector3d::UnitZ()), sigma, X_CT, covariance);
    after += (X_CT.p - truth.p).head<2>().squaredNorm() / kDraws;
    Vector6 left;
    left << X_CT.p - truth.p, LogRotation(X_CT.R * truth.R.conjugate());
    nees += left.dot(covariance.inverse() * left) / kDraws;
  }
  EXPECT_LT(std::sqrt(after), std::sqrt(before) / 3);
  EXPECT_NEAR(nees, 6, 0.6);
}

}  // namespace
}  // namespace kestrel::control
