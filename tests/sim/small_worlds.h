// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

#include "geometry/pose.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "tests/sim/scenes.h"

// Marks to be measured in pictures of them.
namespace kestrel::sim {

// A black room in which colours show as they are given, with things in it.
inline ModelPtr DarkRoom(const std::string& geoms) {
  return CompileScene(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/><quality numslices="64"/></visual>
  <worldbody>{}</worldbody>
</mujoco>)",
                                  geoms));
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
  return CompileScene(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <texture name="spot" type="2d" builtin="gradient" rgb1="1 1 1" rgb2="0 0 0" width="64" height="64"/>
    <material name="spot" texture="spot" specular="0"/>
  </asset>
  <worldbody>{}</worldbody>
</mujoco>)",
                                  spots));
}

}  // namespace kestrel::sim
