// SPDX-License-Identifier: Apache-2.0
#include "control/law/level_camera.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "control/law/bearing_servo.h"
#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "tests/control/law/numeric_interaction.h"

namespace kestrel::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Looking ahead, eq. (6.23), and some 50 degrees down.
Quaterniond Ahead() {
  Matrix3d R_BC;
  R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return Quaterniond(R_BC);
}
Quaterniond Askew() { return ExpRotation({0, Radians(-50), 0.1}) * Ahead(); }

Quaterniond Attitude(double yaw, double pitch, double roll) {
  return Quaterniond(RotationFromTaitBryan({yaw, pitch, roll}));
}

TEST(LevelRotation, WhateverRollAndPitchAThingIsSeenWhereTheLevelAircraftSeesIt) {
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const Quaterniond& R_BC : {Ahead(), Askew()}) {
    const Vector3d p_N(4, -3, 1);
    const Vector3d level = (Attitude(0.7, 0, 0) * R_BC).conjugate() * p_N.normalized();
    for (int i = 0; i < 50; ++i) {
      const double pitch = 1.2 * u(rng), roll = 3 * u(rng);
      const Vector3d s_C = (Attitude(0.7, pitch, roll) * R_BC).conjugate() * p_N.normalized();
      const Vector3d s_V = Levelled({s_C, {}}, LevelRotation(roll, pitch, R_BC)).s;
      EXPECT_LT((s_V - level).norm(), 1e-14);
    }
  }
}

TEST(LevelDown, IsWhereTheEarthIs) {
  EXPECT_LT((LevelDown(Ahead()) - Vector3d(0, 1, 0)).norm(), 1e-12);
  const Quaterniond R_NB = Attitude(2.1, 0.3, -0.4);
  const Vector3d down_C = (R_NB * Askew()).conjugate() * Vector3d::UnitZ();
  EXPECT_LT((LevelRotation(-0.4, 0.3, Askew()) * down_C - LevelDown(Askew())).norm(), 1e-14);
}

TEST(Levelled, ItsCovarianceIsThatOfManyDraws) {
  std::mt19937 rng(12);
  std::normal_distribution<double> normal;
  const Vector3d s_C = Vector3d(0.3, -0.2, 0.9).normalized();
  const Vector3d a = s_C.unitOrthogonal(), b = s_C.cross(a);
  const double sigma_a = 2e-3, sigma_b = 5e-3;
  const Vector3d tilt_sigma(4e-3, 1e-3, 3e-3);
  const Quaterniond R_VC = LevelRotation(0.3, -0.2, Ahead());
  const UncertainBearing expected =
      Levelled({s_C, sigma_a * sigma_a * a * a.transpose() + sigma_b * sigma_b * b * b.transpose()}, R_VC,
               tilt_sigma.cwiseAbs2().asDiagonal());
  const auto point = OnImagePlane(expected);
  ASSERT_TRUE(point);
  Matrix3d bearings = Matrix3d::Zero();
  Eigen::Matrix2d points = Eigen::Matrix2d::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Vector3d drawn = (s_C + sigma_a * normal(rng) * a + sigma_b * normal(rng) * b).normalized();
    const Vector3d tilt = tilt_sigma.cwiseProduct(Vector3d(normal(rng), normal(rng), normal(rng)));
    const Vector3d s_V = ExpRotation(tilt) * (R_VC * drawn);
    bearings += (s_V - expected.s) * (s_V - expected.s).transpose() / kDraws;
    const Eigen::Vector2d d = s_V.head<2>() / s_V.z() - point->s;
    points += d * d.transpose() / kDraws;
  }
  // 20000 draws give a variance to 1 %, one part in the root of half as many
  EXPECT_LT((bearings - expected.covariance).norm(), 0.04 * expected.covariance.norm());
  EXPECT_LT((points - point->covariance).norm(), 0.04 * point->covariance.norm());
}

TEST(OnImagePlane, HasNothingBesideOrBehindTheCamera) {
  EXPECT_FALSE(OnImagePlane({{1, 0, 0}, {}}));
  EXPECT_FALSE(OnImagePlane({{0, 0.6, -0.8}, {}}));
  const auto ahead = OnImagePlane({{0, 0.6, 0.8}, Matrix3d::Zero()});
  ASSERT_TRUE(ahead);
  EXPECT_LT((ahead->s - Eigen::Vector2d(0, 0.75)).norm(), 1e-15);
}

TEST(LevelInteraction, IsTheDerivativeOfWhatTheLevelCameraSeesWhileTheAircraftTumbles) {
  // The aircraft moves, yaws, and rolls and pitches as it likes; the bearing in V knows only the first two.
  const Quaterniond R_BC = Askew();
  const Vector3d p_NQ(3, -2, 1.5), velocity_N(0.4, -0.7, 0.2);
  const double yaw = 0.6, yaw_rate = 0.35;
  const auto seen = [&](double t) {
    const double pitch = 0.2 + 0.9 * t, roll = -0.5 - 1.3 * t;
    const Quaterniond R_NC = Attitude(yaw + yaw_rate * t, pitch, roll) * R_BC;
    const Vector3d s_C = R_NC.conjugate() * (p_NQ - velocity_N * t).normalized();
    return Levelled({s_C, {}}, LevelRotation(roll, pitch, R_BC)).s;
  };
  const double h = kNumericStep;
  const Vector3d numeric = (seen(h) - seen(-h)) / (2 * h);
  const Quaterniond R_NV = Attitude(yaw, 0, 0) * R_BC;
  const Eigen::MatrixXd L = LevelInteraction(BearingInteraction(seen(0), p_NQ.norm()), LevelDown(R_BC));
  Eigen::Vector4d input;
  input << R_NV.conjugate() * velocity_N, yaw_rate;
  EXPECT_LT((L * input - numeric).norm(), 1e-8);
}

}  // namespace
}  // namespace kestrel::control
