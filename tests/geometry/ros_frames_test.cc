// SPDX-License-Identifier: Apache-2.0
#include "geometry/ros_frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(RosFrames, WhatABodyPointsAtIsTheSameInBoth) {
  const Quaterniond R_NB = ExpRotation({0.3, -0.7, 1.9});
  const Quaterniond R_ros = WorldBodyToRos(R_NB);
  for (const Vector3d& v_B :
       {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(0.2, -0.4, 0.5)})
    EXPECT_LT((R_ros * BodyToRos(v_B) - WorldToRos(R_NB * v_B)).norm(), 1e-15);
  EXPECT_LT(WorldBodyToRos(R_ros).angularDistance(R_NB), 1e-15);  // its own inverse
}

TEST(RosFrames, NorthAndLevelIsAYawOf90Degrees) {
  const Quaterniond R = WorldBodyToRos(Quaterniond::Identity());
  EXPECT_LT((R * Vector3d(1, 0, 0) - Vector3d(0, 1, 0)).norm(), 1e-15);   // forward is north
  EXPECT_LT((R * Vector3d(0, 1, 0) - Vector3d(-1, 0, 0)).norm(), 1e-15);  // left is west
  EXPECT_LT((R * Vector3d(0, 0, 1) - Vector3d(0, 0, 1)).norm(), 1e-15);   // up is up
}

TEST(RosFrames, PosesChainTheSameWay) {
  const Pose X_NB{ExpRotation({0.1, 0.2, 2.0}), {10, -20, -5}};
  const Pose X_BC{ExpRotation({-0.4, 1.1, 0.3}), {0.1, 0.02, 0.05}};
  const Pose X_NC = X_NB * X_BC;
  const Pose chained = WorldBodyToRos(X_NB) * BodyCameraToRos(X_BC);
  EXPECT_LT((chained.p - WorldToRos(X_NC.p)).norm(), 1e-14);
  const Vector3d ahead_C(0, 0, 1);  // a camera's axes are the same
  EXPECT_LT((chained.R * ahead_C - WorldToRos(X_NC.R * ahead_C)).norm(), 1e-14);
  const Pose X_NT{ExpRotation({0, 0, 0.4}), {1, 2, 0}};
  const Pose in_pad = BodyBodyToRos(X_NT.Inverse() * X_NB);
  const Pose through_pad = WorldBodyToRos(X_NT) * in_pad;
  EXPECT_LT((through_pad.p - WorldToRos(X_NB.p)).norm(), 1e-14);
  EXPECT_LT(through_pad.R.angularDistance(WorldBodyToRos(X_NB.R)), 1e-14);
}

}  // namespace
}  // namespace kestrel
