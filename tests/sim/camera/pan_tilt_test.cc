// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/pan_tilt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/tait_bryan.h"
#include "sim/simulator.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

const Vector3d kZero = Vector3d::Zero();

Pose Somewhere(double yaw, double pitch, double roll, const Vector3d& p_N) {
  return {Eigen::Quaterniond(RotationFromTaitBryan({yaw, pitch, roll})), p_N};
}
// Where the middle of the image looks.
Vector3d RayN(const PanTiltAngles& angles, const Pose& X_NB) {
  return X_NB.R * (PlatformPose(angles, Vector3d::Zero()).R * Vector3d::UnitZ());
}

TEST(PanTilt, AtZeroTheCameraLooksAheadWithItsTopUp) {
  const Pose X_BC = PlatformPose({}, {0.1, 0.2, 0.3});
  EXPECT_LT((X_BC.R * Vector3d::UnitZ() - Vector3d::UnitX()).norm(), 1e-12);  // forward
  EXPECT_LT((X_BC.R * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-12);  // right
  EXPECT_LT((X_BC.R * Vector3d::UnitY() - Vector3d::UnitZ()).norm(), 1e-12);  // down
  EXPECT_EQ(X_BC.p, Vector3d(0.1, 0.2, 0.3));
}

TEST(PanTilt, PannedItLooksRightAndTiltedUp) {
  EXPECT_GT(RayN({0.1, 0}, {}).y(), 0);
  EXPECT_LT(RayN({0, 0.1}, {}).z(), 0);
}

TEST(PanTilt, IsAMountOfTheSamePanWhosePitchIsTakenFromStraightDown) {
  for (const double pan_deg : {-120.0, 0.0, 35.0}) {
    for (const double tilt_deg : {-90.0, -30.0, 0.0}) {
      vision::CameraMount mount;
      mount.yaw_deg = pan_deg, mount.pitch_deg = tilt_deg + 90;
      const Pose fixed = vision::MountPose(mount);
      const Pose turned = PlatformPose({Radians(pan_deg), Radians(tilt_deg)}, mount.position_m);
      EXPECT_LT(fixed.R.angularDistance(turned.R), 1e-7) << pan_deg << ' ' << tilt_deg;
      EXPECT_EQ(fixed.p, turned.p);
    }
  }
}

TEST(PanTilt, LooksAtAPointWhereverTheAircraftIsAndHowItLeans) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const PanTiltParameters free{-180, 180, -90, 90, 90};
  const Vector3d position_m(0.2, 0.1, 0.3);
  for (int i = 0; i < 200; ++i) {
    const Pose X_NB = Somewhere(3 * number(random), 0.4 * number(random), 0.4 * number(random),
                                10 * Vector3d(number(random), number(random), number(random)));
    const Vector3d p_N(20 + number(random), 20 * number(random), 20 * number(random));
    const PanTiltAngles angles = AnglesFor(LookAt{p_N}, X_NB, position_m, {}, free);
    const Vector3d p_C = (X_NB * PlatformPose(angles, position_m)).Inverse() * p_N;
    ASSERT_LT(p_C.head<2>().norm(), 1e-9);
    ASSERT_GT(p_C.z(), 0);
  }
}

TEST(PanTilt, LooksTheSameWayInNHoweverTheAircraftLeans) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  const PanTiltParameters free{-180, 180, -90, 90, 90};
  const Vector3d wanted = RayN({0.7, -0.5}, {});
  for (int i = 0; i < 200; ++i) {
    const Pose X_NB = Somewhere(3 * number(random), 0.4 * number(random), 0.4 * number(random), kZero);
    const PanTiltAngles angles = AnglesFor(LookInN{0.7, -0.5}, X_NB, kZero, {}, free);
    ASSERT_LT((RayN(angles, X_NB) - wanted).norm(), 1e-9);
  }
}

TEST(PanTilt, StopsAtItsLimits) {
  const PanTiltParameters p{-100, 110, -80, 20, 90};
  const auto degrees = [&](double pan, double tilt) {
    const PanTiltAngles a = AnglesFor(LookFromAircraft{Radians(pan), Radians(tilt)}, {}, kZero, {}, p);
    return Eigen::Vector2d(Degrees(a.pan), Degrees(a.tilt));
  };
  EXPECT_LT((degrees(50, -40) - Eigen::Vector2d(50, -40)).norm(), 1e-9);
  EXPECT_LT((degrees(150, 60) - Eigen::Vector2d(110, 20)).norm(), 1e-9);
  EXPECT_LT((degrees(-150, -89) - Eigen::Vector2d(-100, -80)).norm(), 1e-9);
}

TEST(PanTilt, StraightDownThePanStays) {
  const PanTiltAngles angles = AnglesFor(LookAt{{0, 0, 10}}, {}, kZero, {0.8, -0.3}, {});
  EXPECT_EQ(angles.pan, 0.8);
  EXPECT_NEAR(angles.tilt, -Radians(90), 1e-12);
  const PanTiltAngles there =
      AnglesFor(LookAt{{0, 0, 0}}, {}, kZero, {0.8, -0.3}, {});  // in the camera itself
  EXPECT_EQ(there.pan, 0.8);
  EXPECT_EQ(there.tilt, -0.3);
}

TEST(PanTilt, TurnsAtItsRateAndNotBeyondWhatIsAsked) {
  PanTiltParameters p;
  p.rate_deg_s = 60;
  PanTilt platform(p, kZero, {});
  platform.Turn(LookFromAircraft{Radians(45), Radians(-10)});
  for (int i = 0; i < 250; ++i) platform.Step(0.002, {});  // 0.5 s: 30 degrees
  EXPECT_NEAR(Degrees(platform.angles().pan), 30, 1e-9);
  EXPECT_NEAR(Degrees(platform.angles().tilt), -10, 1e-9);
  for (int i = 0; i < 250; ++i) platform.Step(0.002, {});
  EXPECT_NEAR(Degrees(platform.angles().pan), 45, 1e-9);
}

TEST(PanTilt, HoldsWhatItBeganWith) {
  PanTilt platform({}, kZero, {0.4, -0.6});
  for (int i = 0; i < 100; ++i) platform.Step(0.01, Somewhere(1, 0.2, 0.3, {1, 2, 3}));
  EXPECT_EQ(platform.angles().pan, 0.4);
  EXPECT_EQ(platform.angles().tilt, -0.6);
}

TEST(PanTilt, FollowsAPointWhileTheAircraftTurns) {
  PanTilt platform({}, kZero, {});
  const Vector3d p_N(20, 5, 10);
  platform.Turn(LookAt{p_N});
  Pose X_NB;
  for (int i = 0; i < 1500; ++i) {
    X_NB = Somewhere(0.5 * std::sin(0.002 * i), 0.1, -0.1, kZero);
    platform.Step(0.002, X_NB);
  }
  EXPECT_LT((RayN(platform.angles(), X_NB) - p_N.normalized()).norm(), 1e-9);
}

TEST(PanTilt, HoldsTheCameraAsAMountHasItWhereItCan) {
  vision::CameraMount mount;
  ASSERT_TRUE(AnglesOf(mount, {}));
  EXPECT_NEAR(AnglesOf(mount, {})->tilt, -Radians(90), 1e-12);
  mount.yaw_deg = 30, mount.pitch_deg = 60;
  EXPECT_NEAR(AnglesOf(mount, {})->pan, Radians(30), 1e-12);
  EXPECT_NEAR(AnglesOf(mount, {})->tilt, -Radians(30), 1e-12);
  mount.pitch_deg = -10;  // past straight down
  EXPECT_FALSE(AnglesOf(mount, {}));
  mount.pitch_deg = 60, mount.roll_deg = 1;
  EXPECT_FALSE(AnglesOf(mount, {}));
  mount.roll_deg = 0, mount.yaw_deg = 179;  // it turns to 170
  EXPECT_FALSE(AnglesOf(mount, {}));
}

}  // namespace
}  // namespace kestrel::sim
