// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "sim/render/ray/lens.h"

namespace kestrel::sim::ray {

// A triangle whose front is towards the viewpoint, in C.
struct alignas(64) TileTriangle {
  // Of the edge across from each corner, the normal of its plane: a ray d passes inside where all three dot products
  // are >= 0. Two triangles with an edge in common have it with opposite signs, to the last bit: no ray slips through.
  float edge[3][3];
  float normal[3];
  float height;  // normal times a corner, below 0: t = height / (normal d)
  std::uint32_t face;
  std::int32_t thing;
};

// Pixels of a tile by their rows and columns in it, a bit for each.
struct TilePixels {
  std::uint32_t rows = 0, columns = 0;
};

// The triangles that the rays of a tile may meet.
struct TileTriangles {
  struct Entry {
    std::uint32_t index, columns;
  };
  std::vector<TileTriangle> all;
  std::vector<TilePixels> seen_by;  // of each
  // Of the row r of the tile those from first[r] to first[r + 1] - 1.
  std::vector<Entry> by_row;
  std::uint32_t first[Lens::kTile + 1] = {};

  void Clear();
  void Add(const TileTriangle& triangle, const TilePixels& pixels);
  void SortByRow();  // after the last
};

}  // namespace kestrel::sim::ray
