// SPDX-License-Identifier: Apache-2.0
#include "geometry/tait_bryan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace kestrel {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::cos;
using std::sin;

constexpr double kPi = std::numbers::pi;

// Calls f(angles) all over the ranges, the ends of pitch included when poles is true; returns the number of
// calls.
template <class F>
int ForAllAngles(bool poles, F f) {
  int calls = 0;
  for (int yaw = -175; yaw <= 180; yaw += 15) {
    for (int pitch = -90; pitch <= 90; pitch += 10) {
      if (!poles && std::abs(pitch) == 90) continue;
      for (int roll = -170; roll <= 180; roll += 25, ++calls)
        f(TaitBryan{Radians(yaw), Radians(pitch), Radians(roll)});
    }
  }
  return calls;
}

// eq. (4.3) and (4.4) as printed: from coordinates of A to coordinates of B
Matrix3d ThesisProduct(const TaitBryan& a) {
  Matrix3d z, y, x;
  z << cos(a.yaw), sin(a.yaw), 0, -sin(a.yaw), cos(a.yaw), 0, 0, 0, 1;
  y << cos(a.pitch), 0, -sin(a.pitch), 0, 1, 0, sin(a.pitch), 0, cos(a.pitch);
  x << 1, 0, 0, 0, cos(a.roll), sin(a.roll), 0, -sin(a.roll), cos(a.roll);
  return x * y * z;
}

Matrix3d ThesisMatrix(const TaitBryan& a) {
  const double ct = cos(a.pitch), st = sin(a.pitch), cp = cos(a.yaw), sp = sin(a.yaw), cf = cos(a.roll),
               sf = sin(a.roll);
  Matrix3d m;
  m << ct * cp, ct * sp, -st,                                   //
      sf * st * cp - cf * sp, sf * st * sp + cf * cp, sf * ct,  //
      cf * st * cp + sf * sp, cf * st * sp - sf * cp, cf * ct;
  return m;
}

TEST(TaitBryan, RotationIsTheTransposeOfTheThesisMatrix) {
  const int calls = ForAllAngles(true, [](const TaitBryan& a) {
    const Matrix3d R_AB = RotationFromTaitBryan(a);
    EXPECT_LT((R_AB.transpose() - ThesisProduct(a)).norm(), 1e-14);
    EXPECT_LT((R_AB.transpose() - ThesisMatrix(a)).norm(), 1e-14);
  });
  EXPECT_EQ(calls, 24 * 19 * 15);
}

TEST(TaitBryan, RotationIsYawThenPitchThenRollAboutTheMovedAxes) {
  // about axes that stay, in the order of the turns: each next axis is where the turns so far have brought it
  ForAllAngles(true, [](const TaitBryan& a) {
    const Matrix3d first = AngleAxisd(a.yaw, Vector3d::UnitZ()).toRotationMatrix();
    const Matrix3d second = AngleAxisd(a.pitch, first.col(1)).toRotationMatrix() * first;
    const Matrix3d third = AngleAxisd(a.roll, second.col(0)).toRotationMatrix() * second;
    EXPECT_LT((RotationFromTaitBryan(a) - third).norm(), 1e-14);
  });
}

TEST(TaitBryan, YawIsClockwisePitchNoseUpRollRightWingDown) {
  const Vector3d forward = Vector3d::UnitX(), right = Vector3d::UnitY();
  const Vector3d heading_N = RotationFromTaitBryan({.yaw = 0.3}) * forward;
  EXPECT_NEAR(heading_N.x(), cos(0.3), 1e-15);
  EXPECT_NEAR(heading_N.y(), sin(0.3), 1e-15);  // to the east
  EXPECT_NEAR((RotationFromTaitBryan({.pitch = 0.3}) * forward).z(), -sin(0.3), 1e-15);
  EXPECT_NEAR((RotationFromTaitBryan({.roll = 0.3}) * right).z(), sin(0.3), 1e-15);
}

TEST(TaitBryan, AnglesComeBackOverTheWholeSphere) {
  const int calls = ForAllAngles(false, [](const TaitBryan& a) {
    const TaitBryan back = TaitBryanFromRotation(RotationFromTaitBryan(a));
    // half a turn may come back as minus half a turn, by rounding
    EXPECT_NEAR(WrapAngle(back.yaw - a.yaw), 0, 1e-13);
    EXPECT_NEAR(back.pitch, a.pitch, 1e-13);
    EXPECT_NEAR(WrapAngle(back.roll - a.roll), 0, 1e-13);
  });
  EXPECT_EQ(calls, 24 * 17 * 15);
}

// Near the poles the arcsine of eq. (4.5) resolves the pitch to half the digits of a double.
constexpr double kPoleResolution = 5e-8;

TEST(TaitBryan, RotationComesBackAtThePolesWithRollZero) {
  int checked = 0;
  ForAllAngles(true, [&](const TaitBryan& a) {
    if (std::abs(a.pitch) < 1.57) return;
    ++checked;
    const Matrix3d R_AB = RotationFromTaitBryan(a);
    const TaitBryan back = TaitBryanFromRotation(R_AB);
    EXPECT_EQ(back.roll, 0);
    EXPECT_NEAR(back.pitch, a.pitch, kPoleResolution);
    EXPECT_LT((RotationFromTaitBryan(back) - R_AB).norm(), kPoleResolution);
    // nose straight up, a roll is a turn back in yaw; straight down, a turn on
    const double turn = a.pitch > 0 ? a.yaw - a.roll : a.yaw + a.roll;
    EXPECT_NEAR(WrapAngle(back.yaw - turn), 0, 1e-12);
  });
  EXPECT_EQ(checked, 24 * 2 * 15);
}

TEST(TaitBryan, RotationComesBackNearThePoles) {
  for (const double off : {1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12}) {
    for (const double sign : {-1.0, 1.0}) {
      const Matrix3d R_AB = RotationFromTaitBryan({.yaw = 2, .pitch = sign * (kPi / 2 - off), .roll = -1});
      // yaw and roll come from elements as small as 1e-9, whose rounding is not the same
      EXPECT_LT((RotationFromTaitBryan(TaitBryanFromRotation(R_AB)) - R_AB).norm(), 10 * kPoleResolution)
          << off;
    }
  }
}

TEST(TaitBryan, ARotationWithRoundingInItIsNotANan) {
  Matrix3d R = RotationFromTaitBryan({.yaw = 0.4, .pitch = kPi / 2});
  R(2, 0) = -1 - 1e-15;
  EXPECT_NEAR(TaitBryanFromRotation(R).pitch, kPi / 2, 1e-15);
  EXPECT_NEAR(TaitBryanFromRotation(R).yaw, 0.4, 1e-12);
}

TEST(YawOf, IsTheYawOfTheThreeAngles) {
  ForAllAngles(false, [](const TaitBryan& a) {
    EXPECT_NEAR(WrapAngle(YawOf(Quaterniond(RotationFromTaitBryan(a))) - a.yaw), 0, 1e-13);
  });
}

TEST(HeadingRotation, TurnsByYawOnly) {
  for (int deg = -180; deg <= 180; deg += 15) {
    const TaitBryan yaw_only{.yaw = Radians(deg)};
    EXPECT_LT((HeadingRotation(yaw_only.yaw).toRotationMatrix() - RotationFromTaitBryan(yaw_only)).norm(),
              1e-14);
  }
}

TEST(WrapAngle, IsTheSameAngleInItsRange) {
  int checked = 0;
  for (double angle = -30; angle < 30; angle += 0.37, ++checked) {
    const double wrapped = WrapAngle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(sin(wrapped), sin(angle), 1e-13);
    EXPECT_NEAR(cos(wrapped), cos(angle), 1e-13);
  }
  EXPECT_GT(checked, 160);
}

TEST(WrapAngle, KeepsTheUpperEndOfItsRangeAndTurnsTheLowerOver) {
  EXPECT_EQ(WrapAngle(kPi), kPi);
  EXPECT_EQ(WrapAngle(-kPi), kPi);
  EXPECT_EQ(WrapAngle(-0.5), -0.5);
  EXPECT_TRUE(std::isnan(WrapAngle(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Degrees, AreRadiansBackAndForth) {
  EXPECT_EQ(Radians(180), kPi);
  EXPECT_NEAR(Degrees(Radians(37.5)), 37.5, 1e-13);
}

}  // namespace
}  // namespace kestrel
