// SPDX-License-Identifier: Apache-2.0
#include "geometry/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace kestrel {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

class Random {
 public:
  Vector3d Vector() { return {normal_(rng_), normal_(rng_), normal_(rng_)}; }
  Quaterniond Rotation() {
    return Quaterniond(normal_(rng_), normal_(rng_), normal_(rng_), normal_(rng_)).normalized();
  }
  Pose NextPose() { return {Rotation(), Vector()}; }

 private:
  std::mt19937 rng_{7};
  std::normal_distribution<double> normal_;
};

Matrix4d Homogeneous(const Pose& X) {
  Matrix4d m = Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = X.R.toRotationMatrix();
  m.topRightCorner<3, 1>() = X.p;
  return m;
}

TEST(Pose, ComposesAndInvertsAsHomogeneousMatricesDo) {
  Random random;
  for (int i = 0; i < 100; ++i) {
    const Pose X_AB = random.NextPose(), X_BC = random.NextPose();
    const Matrix4d m_AB = Homogeneous(X_AB), m_BC = Homogeneous(X_BC);
    EXPECT_LT((Homogeneous(X_AB * X_BC) - m_AB * m_BC).norm(), 1e-13);
    EXPECT_LT((Homogeneous(X_AB.Inverse()) - m_AB.inverse()).norm(), 1e-12);
    const Vector3d p_BQ = random.Vector();
    EXPECT_LT((X_AB * p_BQ - (m_AB * p_BQ.homogeneous()).head<3>()).norm(), 1e-13);
  }
}

TEST(Pose, APointAheadOfAnAircraftFacingEastLiesEastOfIt) {
  const Pose X_NB{Quaterniond(AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ())), {10, 20, -5}};
  EXPECT_LT((X_NB * Vector3d(2, 0, 1) - Vector3d(10, 22, -4)).norm(), 1e-14);
  EXPECT_LT((X_NB.Inverse() * Vector3d(10, 22, -4) - Vector3d(2, 0, 1)).norm(), 1e-14);
}

TEST(Skew, IsTheCrossProduct) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const Vector3d a = random.Vector(), b = random.Vector();
    EXPECT_LT((Skew(a) * b - a.cross(b)).norm(), 1e-14);
  }
}

TEST(ExpRotation, TurnsAboutTheVectorByItsLength) {
  Random random;
  for (const double angle :
       {0.0, 1e-12, 1e-7, 0.99e-6, 1.01e-6, 1e-3, 0.5, 2.0, 3.1, std::numbers::pi, 4.0, 7.0}) {
    for (int i = 0; i < 10; ++i) {
      const Vector3d axis = random.Vector().normalized();
      const Quaterniond R = ExpRotation(angle * axis);
      EXPECT_NEAR(R.norm(), 1, 1e-15);
      EXPECT_LT((R.toRotationMatrix() - AngleAxisd(angle, axis).toRotationMatrix()).norm(), 1e-14) << angle;
    }
  }
}

TEST(ExpRotation, OfASmallVectorIsItsSkewMatrixToFirstOrder) {
  const Vector3d v(3e-9, -2e-9, 1e-9);
  // to the digits that are left after the subtraction of one
  EXPECT_LT((ExpRotation(v).toRotationMatrix() - Matrix3d::Identity() - Skew(v)).norm(), 1e-15);
}

TEST(LogRotation, GivesTheVectorBack) {
  Random random;
  int checked = 0;
  for (const double angle : {0.0, 1e-12, 1e-9, 2.1e-9, 1e-6, 1e-3, 0.5, 2.0, 3.1, std::numbers::pi - 1e-9}) {
    for (int i = 0; i < 10; ++i, ++checked) {
      const Vector3d v = angle * random.Vector().normalized();
      EXPECT_LT((LogRotation(ExpRotation(v)) - v).norm(), 1e-14) << angle;
    }
  }
  EXPECT_EQ(checked, 100);
}

TEST(LogRotation, IsTheSameForBothQuaternionsOfARotation) {
  Random random;
  for (int i = 0; i < 50; ++i) {
    const Quaterniond R = random.Rotation();
    const Quaterniond minus_R(-R.w(), -R.x(), -R.y(), -R.z());
    EXPECT_LT((LogRotation(R) - LogRotation(minus_R)).norm(), 1e-14);
    EXPECT_LE(LogRotation(R).norm(), std::numbers::pi + 1e-15);
  }
}

TEST(LogRotation, GoesTheShortWay) {
  const Vector3d axis(0, 0, 1);
  EXPECT_LT((LogRotation(ExpRotation(4.0 * axis)) - (4.0 - 2 * std::numbers::pi) * axis).norm(), 1e-14);
  EXPECT_NEAR(LogRotation(ExpRotation(std::numbers::pi * axis)).norm(), std::numbers::pi, 1e-15);
}

}  // namespace
}  // namespace kestrel
