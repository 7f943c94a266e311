// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/aircraft/airframe.h"

namespace kestrel::sim {

// A rotor as it is to be seen turning. In B.
struct SeenRotor {
  Eigen::Vector3d hub_B = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_B = -Eigen::Vector3d::UnitZ();  // along the shaft
  double radius_m = 0;
  int spin = 1;  // 1: it turns about the axis as a right-hand screw; -1: the other way
};
std::vector<SeenRotor> SeenRotors(const AirframeParameters& parameters);

// What a viewer shows of a flight's model: a file of glTF 2.0 in its binary form (.glb), of about 1.5 MB at most. The model
// as compiled: everything is where it is in mjModel's qpos0.
//
// glTF has y up. The root of the scene turns from the frame M of the model below it (x north, y west, z up, m) to that: x
// north, y up, z east. Below it are the nodes
//   world     all that does not move
//   aircraft  in the frame F of the vehicle (x forward, y left, z up), with rotor_0, rotor_1, ... as children, whose origin
//             is the hub; extras: axis, in the node's frame, and spin, 1 or -1, as SeenRotor has it
//   pad       in the frame of the pad's body (x along the up of its picture, y to the left of it), with the plate of its
//             deck as its child `deck`, where there is one
//   target_0, target_1, ...  in the order of the scenario
// What is put before a lens or over the pad at times is left out. extras of the root: `sky`, a data URL of the sky all round
// (as gltf::SkyUrl has it), and `lights`, of each its direction in M, ambient and diffuse: the colour of a thing is its
// own times their sum, as MuJoCo draws it.
//
// Meshes are made coarser, and pictures smaller, the more there are of them. Reads the model alone; may be called on any thread.
std::string SceneGlb(const mjModel* model, const std::vector<SeenRotor>& rotors);

}  // namespace kestrel::sim
