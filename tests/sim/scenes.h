// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <ostream>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/world/scene.h"

// Small worlds for the tests of renderers: together they have every kind of geom, texture, light and blending
// that is drawn.
namespace kestrel::sim {

// The text compiled, with these files at hand: picture.png (2-D, 48 x 32, nothing of it symmetric),
// faces.png (the six faces of a cube, 32 x 32 each, all different), square.png (one of them) and relief.png
// (6 x 5, heights). Throws std::runtime_error if the text does not compile.
ModelPtr CompileScene(const std::string& xml);

// MakeData, and all positions computed.
DataPtr StateOf(const mjModel* model);

struct TestScene {
  std::string name, xml;
  Pose X_NC;
  // It shows what follows from the order in which OpenGL draws, not from what there is: all layers of a
  // hollow transparent thing, things that are hidden by the sky's cylinder or by the haze's cone.
  bool opengl_alone = false;
};
inline std::ostream& operator<<(std::ostream& out, const TestScene& scene) { return out << scene.name; }

const std::vector<TestScene>& TestScenes();

// Optical axis along north turned by yaw (to the east) and pitch (up), rad.
Pose LookingFrom(const Eigen::Vector3d& p_NC, double yaw, double pitch, double roll = 0);

}  // namespace kestrel::sim
