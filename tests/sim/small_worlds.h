// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <string>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "sim/frames.h"
#include "sim/scene.h"

// Worlds of a few lines, for tests of what is drawn.
namespace kestrel {

// An aircraft's camera that looks ahead: its x to the right, its z forward.
inline Pose LookingAlong(const TaitBryan& angles, const Eigen::Vector3d& p_NC) {
  const Eigen::Matrix3d R_BC = (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
  return {Eigen::Quaterniond(RotationFromTaitBryan(angles) * R_BC), p_NC};
}

inline ModelPtr ModelOf(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "test.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  char error[500] = "";
  ModelPtr model(mj_loadXML("test.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  EXPECT_TRUE(model) << error;
  return model;
}

// A black room in which colours show as they are given, with things in it.
inline ModelPtr DarkRoom(const std::string& geoms) {
  return ModelOf(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/><quality numslices="64"/></visual>
  <worldbody>{}</worldbody>
</mujoco>)",
                             geoms));
}

inline DataPtr Computed(const mjModel* model) {
  DataPtr data = MakeData(model);
  mj_forward(model, data.get());
  return data;
}

// A flat disc in the plane of the image: its picture is a circle round the projection of its centre.
inline std::string Disc(const Pose& X_NC, const Eigen::Vector3d& p_CQ, double radius, const char* rgb) {
  mjtNum qpos[7];
  PoseToMujoco({X_NC.R, X_NC * p_CQ}, qpos);
  return fmt::format(
      R"(<geom type="cylinder" pos="{} {} {}" quat="{} {} {} {}" size="{} 1e-5" rgba="{} 1"/>)", qpos[0],
      qpos[1], qpos[2], qpos[3], qpos[4], qpos[5], qpos[6], radius, rgb);
}

// White spots on black that fade towards their rims, seen as they are given. Spot: its middle and its normal
// z.
inline std::string Spot(const Pose& X_ND, double radius) {
  mjtNum qpos[7];
  PoseToMujoco(X_ND, qpos);
  return fmt::format(
      R"(<geom type="cylinder" pos="{} {} {}" quat="{} {} {} {}" size="{} 1e-5" material="spot"/>)", qpos[0],
      qpos[1], qpos[2], qpos[3], qpos[4], qpos[5], qpos[6], radius);
}
inline ModelPtr RoomWithSpots(const std::string& spots) {
  return ModelOf(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <texture name="spot" type="2d" builtin="gradient" rgb1="1 1 1" rgb2="0 0 0" width="64" height="64"/>
    <material name="spot" texture="spot" specular="0"/>
  </asset>
  <worldbody>{}</worldbody>
</mujoco>)",
                             spots));
}

}  // namespace kestrel
