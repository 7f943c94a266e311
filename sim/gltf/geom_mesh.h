// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>

#include "sim/gltf/mesh.h"

namespace kestrel::sim::gltf {

// A geom in its own frame, with its places in its material's picture, as MuJoCo draws it. A plane without end is one of
// 2 km. Empty: of a kind that is not drawn.
Mesh GeomMesh(const mjModel* model, int geom);

// How many triangles it has that can be made fewer: those of a mesh and of a height field.
std::size_t FacesOf(const mjModel* model, int geom);

}  // namespace kestrel::sim::gltf
