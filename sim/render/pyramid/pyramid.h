// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <new>
#include <vector>

namespace kestrel::sim::ray {

// Of memory that is written before it is read, and need not be cleared: that of a large picture takes as long as to
// make half of its sizes.
template <class T>
struct Uncleared : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = Uncleared<U>;
  };
  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
};

// Of a picture whose red, green and blue differ.
struct ColourTexel {
  std::uint8_t blue, green, red;
  bool operator==(const ColourTexel&) const = default;
};

// A picture at all sizes down to one texel, for filtering by footprint; or the six faces of a cube, in
// OpenGL's order (+x, -x, +y, -y, +z, -z). Trilinear filtering mixes the two sizes next to the footprint,
// four texels of each. Here they are mixed beforehand, for four footprints in each octave, so that four
// texels do.
//
// A texel is three bytes; or one, where red, green and blue are the same all over the picture, as of a printed pad.
// Every level has a border of one texel: that of the opposite side where the picture repeats, of the face beside it on a
// cube, the nearest of its own where one picture is on all six.
struct Pyramid {
  static constexpr int kMaxLevels = 64;

  // One of the two is empty. Eight bytes can be read from every texel on.
  std::vector<ColourTexel, Uncleared<ColourTexel>> texels;
  std::vector<std::uint8_t, Uncleared<std::uint8_t>> grey_texels;
  int levels = 0;
  std::int32_t face_stride = 0;  // from a face's texel to the same one of the next; 0: all have one picture
  // Of each level; offset: of the texel (0, 0) of the first face. Level 0 is the picture itself, for
  // footprints below one texel; the others are for those whose square is in one half octave each, [1, 1.5),
  // [1.5, 2), ...
  alignas(64) float width[kMaxLevels] = {}, height[kMaxLevels] = {};
  alignas(64) std::int32_t stride[kMaxLevels] = {}, offset[kMaxLevels] = {};
};

// Of a texture of the model.
Pyramid MakePyramid(const mjModel* model, int texture);

}  // namespace kestrel::sim::ray
