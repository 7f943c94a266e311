// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/render/ray/lens.h"
#include "sim/render/ray/render_scene.h"
#include "sim/render/ray/tile_triangles.h"

// The inner loops, in SIMD: compiled for several instruction sets, the best of which is chosen when the
// program runs. A packet is as many rays as a vector is wide, at most 16.
namespace kestrel::sim::ray {

struct Canvas {
  // One of the two is drawn into.
  std::uint8_t* bgr = nullptr;  // 3 bytes a pixel
  float* grey = nullptr;        // 0 to 255, not rounded
  std::size_t step = 0;         // a row: bytes, or floats
  // What each pixel shows: the thing, which side of it, what lies over it. Where neighbours differ there is
  // an edge. Row stride as the lens's table.
  std::uint32_t* code = nullptr;
  // Of each row, tile by tile: the code that all of its pixels in the tile have, or kMixed.
  std::uint32_t* common = nullptr;
  static constexpr std::uint32_t kMixed = 0xffffffff;
};

// What is needed to draw a row.
struct Slice {
  const Lens* lens = nullptr;
  const RenderScene* things = nullptr;
  const SceneInstance* placement = nullptr;
  // Of each tile of the row of tiles: a bit for each thing that some ray of the tile may meet, and the triangles of
  // those that are opaque.
  std::uint64_t* visible = nullptr;
  TileTriangles* triangles = nullptr;
  int words = 0;  // of `visible`, for each tile
  bool shadows = false;
};

inline int VisibleWords(const RenderScene& things) { return static_cast<int>((things.all.size() + 63) / 64); }

// Fills slice.visible and slice.triangles of all tiles of a row of tiles, for its rows [begin, end).
void Cull(const Slice& slice, int begin, int end);
// Draws the rows [begin, end) of one row of tiles, a ray to a pixel.
void DrawRows(const Slice& slice, int begin, int end, const Canvas& canvas);
// Draws the pixels at edges in the rows [begin, end) of one row of tiles again, 8 rays to each. The row
// of tiles and those above and below are drawn.
void SmoothRows(const Slice& slice, int begin, int end, const Canvas& canvas);
// Distance along the ray and id of the geom of each pixel of the rows [begin, end), of what is opaque.
void TraceRows(const Slice& slice, int begin, int end, float* depth_m, std::int32_t* geom,
               std::size_t stride);

// The instruction set in use.
const char* InstructionSet();

}  // namespace kestrel::sim::ray
