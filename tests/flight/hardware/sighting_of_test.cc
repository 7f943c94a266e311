// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/sighting_of.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::flight {
namespace {

const vision::Pinhole kCamera{.width_px = 640, .height_px = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};

mission::MissionParts Parts() {
  mission::MissionParts parts;
  parts.camera = kCamera;
  // Looks down, the image's top ahead, 0.1 m before the middle.
  Eigen::Matrix3d R_BC;
  R_BC << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  parts.X_BC = {Eigen::Quaterniond(R_BC), {0.1, 0, 0.05}};
  parts.pad.length_m = 1.2, parts.pad.width_m = 0.8;
  return parts;
}

// By the information that vision has of the same points in the axes of C, turned into those of T.
TEST(SightingOf, ItsCovarianceIsThatOfThePointsInTheCamera) {
  const mission::MissionParts parts = Parts();
  const mission::TargetFix fix{.p_TB = {0.2, -0.1, -4}, .yaw_TB = 0.6, .inliers = 60, .residual_px = 0.9};
  control::VehicleState state;
  state.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({.yaw = 2, .pitch = 0.05, .roll = -0.03}));
  const control::Sighting sighting = SightingOf(fix, 12.5, state, parts);
  EXPECT_EQ(sighting.t_s, 12.5);
  EXPECT_EQ(sighting.p_TB, fix.p_TB);
  const TaitBryan angles = TaitBryanFromRotation(sighting.R_TB.toRotationMatrix());
  EXPECT_NEAR(angles.yaw, 0.6, 1e-9);
  EXPECT_NEAR(angles.pitch, 0.05, 1e-9);
  EXPECT_NEAR(angles.roll, -0.03, 1e-9);

  const Pose X_TB{sighting.R_TB, sighting.p_TB};
  const Pose X_CT = (X_TB * parts.X_BC).Inverse();
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 21; ++i)
    for (int j = 0; j < 21; ++j) points.emplace_back(1.2 * (i / 20.0 - 0.5), 0.8 * (j / 20.0 - 0.5));
  const auto information = vision::PoseInformation(points, kCamera, X_CT);
  ASSERT_TRUE(information);
  const Eigen::Matrix<double, 6, 6> in_C = 0.9 * 0.9 * 441 / 60 * information->inverse();
  // To where the aircraft then is in T, by differences.
  Eigen::Matrix<double, 6, 6> J;
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-5;
    const auto moved = [&](double by) {
      const Eigen::Vector3d dt =
          k < 3 ? Eigen::Vector3d(by * Eigen::Vector3d::Unit(k)) : Eigen::Vector3d::Zero();
      const Eigen::Vector3d dr =
          k < 3 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(by * Eigen::Vector3d::Unit(k - 3));
      const Pose X_CT_moved{ExpRotation(dr) * X_CT.R, X_CT.p + dt};
      return X_CT_moved.Inverse() * parts.X_BC.Inverse();
    };
    const Pose up = moved(kStep), down = moved(-kStep);
    J.col(k).head<3>() = (up.p - down.p) / (2 * kStep);
    const Eigen::Quaterniond turn = up.R * down.R.conjugate();
    J.col(k).tail<3>() = 2 * turn.vec() / (2 * kStep) * (turn.w() < 0 ? -1 : 1);
  }
  const Eigen::Matrix<double, 6, 6> expected = J * in_C * J.transpose();
  EXPECT_LT((sighting.covariance - expected).norm(), 1e-3 * expected.norm());
  EXPECT_GT(std::sqrt(expected(0, 0)), 0.001);
  EXPECT_LT(std::sqrt(expected(0, 0)), 0.1);
}

TEST(SightingOf, ItHasACovarianceDownToTheGround) {
  for (const double height_m : {5.0, 1.0, 0.4, 0.2}) {
    const mission::TargetFix fix{.p_TB = {0, 0, -height_m}, .inliers = 60, .residual_px = 0.9};
    const control::Sighting sighting = SightingOf(fix, 0, {}, Parts());
    EXPECT_GT(sighting.covariance(0, 0), 0) << height_m;
    EXPECT_LT(sighting.covariance(0, 0), 0.1) << height_m;
  }
}

TEST(SightingOf, WhereTheCameraCannotSeeThePadNothingIsKnownOfIt) {
  const mission::TargetFix fix{.p_TB = {50, 0, -4}, .inliers = 60, .residual_px = 0.9};
  EXPECT_TRUE(std::isnan(SightingOf(fix, 0, {}, Parts()).covariance(0, 0)));
}

}  // namespace
}  // namespace kestrel::flight
