// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

namespace kestrel::ray {

// A picture at all sizes down to one texel, each half of the one before, for filtering by footprint; or the
// six faces of a cube, in OpenGL's order (+x, -x, +y, -y, +z, -z), each with a pyramid of its own.
//
// A texel is kept with its right neighbour, channel by channel (b b' g g' r r' 0 0), so that one load of
// eight bytes and one multiply-add blend the two. Every level has a border of one texel: that of the opposite
// side where the picture repeats, the same again on the face of a cube.
struct Pyramid {
  static constexpr int kMostLevels = 16;

  std::vector<std::uint64_t> texels;
  int levels = 0;
  int faces = 1;
  std::int32_t face_stride = 0;  // from a face's texel to the same one of the next face
  // Of each level; offset: of the texel (0, 0) of the first face.
  alignas(64) float width[kMostLevels] = {}, height[kMostLevels] = {};
  alignas(64) std::int32_t stride[kMostLevels] = {}, offset[kMostLevels] = {};
};

// Of a texture of the model.
Pyramid MakePyramid(const mjModel* model, int texture);

}  // namespace kestrel::ray
