// SPDX-License-Identifier: Apache-2.0
#include "mission/servo/servo_sight.h"

#include <gtest/gtest.h>

#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::mission {
namespace {

using Eigen::Vector3d;

const vision::Pinhole kCamera{
    .width_px = 640, .height_px = 480, .fx = 810, .fy = 810, .cx = 319.5, .cy = 239.5};

MissionParts Parts() {
  MissionParts parts;
  parts.camera = kCamera;
  parts.X_BC = vision::MountPose({});
  parts.pad.length_m = 1.2, parts.pad.width_m = 0.9;
  return parts;
}

// The pad as a tracker without error has it, of an aircraft there; T lies north-up in N.
vision::PadObservation Seen(const Pose& X_NB) {
  vision::PadObservation seen;
  seen.X_CT = (X_NB * vision::MountPose({})).Inverse();
  seen.H_w = vision::HomographyFromPose(seen.X_CT, kCamera);
  return seen;
}
control::VehicleState StateAt(double t_s, const Pose& X_NB) {
  control::VehicleState state;
  state.t_s = t_s, state.p_NB = X_NB.p, state.R_NB = X_NB.R;
  return state;
}
Pose At(const Vector3d& p, double yaw, double pitch = 0, double roll = 0) {
  return {Eigen::Quaterniond(RotationFromTaitBryan({yaw, pitch, roll})), p};
}

TEST(ServoSight, AtTheGoalEachLawStandsStill) {
  for (const double yaw : {0.0, 2.0}) {
    ServoSight sight(Parts(), {.height_m = 3, .yaw_rad = yaw});
    EXPECT_LT((sight.goal_T() - Vector3d(0, 0, -3)).norm(), 1e-12);
    const Pose X_NB = At(sight.goal_T(), yaw);
    const control::VehicleState state = StateAt(1, X_NB);
    sight.AddState(state);
    for (const std::string& law : ServoLawNames()) {
      const ServoView& view = law == "points_adaptive" ? sight.LookForDepth(Seen(X_NB), kCamera, 1, state)
                                                       : sight.Look(Seen(X_NB), kCamera, 1, state);
      const ServoAnswer answer = AnswerOf(law, view, 1);
      EXPECT_EQ(answer.state, control::ServoState::kRegular) << law;
      EXPECT_LT(answer.twist.v.norm() + std::abs(answer.twist.yaw_rate), 1e-9) << law;
      EXPECT_LT(sight.ReportOf(answer, kCamera)->error_px, 1e-6);
    }
  }
}

TEST(ServoSight, ATiltIsNoMotionInTheLevelCameraAndOneInTheOther) {
  const auto error_px = [](bool level) {
    ServoSight sight(Parts(), {.height_m = 3, .level_camera = level});
    const Pose X_NB = At({0, 0, -3}, 0, 0.1, -0.05);
    const control::VehicleState state = StateAt(1, X_NB);
    sight.AddState(state);
    const ServoView& view = sight.Look(Seen(X_NB), kCamera, 1, state);
    return sight.ReportOf(AnswerOf("pose", view, 1), kCamera)->error_px;
  };
  // The lever of the camera, 5 cm below the centre, remains: 5 mm at 3 m.
  EXPECT_LT(error_px(true), 2);
  EXPECT_GT(error_px(false), 60);
}

TEST(ServoSight, EachLawMovesTowardsTheGoalAndTurnsToIt) {
  ServoSight sight(Parts(), {.height_m = 3});
  const Pose X_NB = At({0.2, -0.15, -3.4}, 0.3);
  const control::VehicleState state = StateAt(1, X_NB);
  sight.AddState(state);
  const Pose X_BC = vision::MountPose({});
  for (const std::string& law : ServoLawNames()) {
    const ServoView& view = law == "points_adaptive" ? sight.LookForDepth(Seen(X_NB), kCamera, 1, state)
                                                     : sight.Look(Seen(X_NB), kCamera, 1, state);
    const ServoAnswer answer = AnswerOf(law, view, 1);
    const Vector3d v_N = X_NB.R * (X_BC.R * answer.twist.v);
    EXPECT_GT(v_N.z(), 0.1) << law;                  // down
    EXPECT_LT(answer.twist.yaw_rate, -0.15) << law;  // back to the left
    EXPECT_GT(v_N.dot(sight.goal_T() - X_NB.p), 0) << law;
  }
  EXPECT_NEAR(sight.height_m(), 3.35, 1e-9);  // of the camera
}

TEST(ServoSight, OverATiltedPadTheGoalIsStraightAboveItsMiddle) {
  ServoSight sight(Parts(), {.height_m = 2, .pad_tilt_rad = 0.3});
  // The pad's own vertical leans; its top, ahead, is raised.
  const Eigen::Quaterniond R_NT(RotationFromTaitBryan({0, 0.3, 0}));
  EXPECT_LT((R_NT * sight.goal_T() - Vector3d(0, 0, -2)).norm(), 1e-12);
}

}  // namespace
}  // namespace kestrel::mission
