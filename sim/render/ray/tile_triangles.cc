// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/tile_triangles.h"

#include <algorithm>
#include <bit>

namespace kestrel::sim::ray {

void TileTriangles::Clear() {
  all.clear();
  seen_by.clear();
  by_row.clear();
  std::fill_n(first, Lens::kTile + 1, 0u);
}

void TileTriangles::Add(const TileTriangle& triangle, const TilePixels& pixels) {
  all.push_back(triangle);
  seen_by.push_back(pixels);
  for (std::uint32_t rows = pixels.rows; rows != 0; rows &= rows - 1) ++first[std::countr_zero(rows) + 1];
}

void TileTriangles::SortByRow() {
  for (int r = 0; r < Lens::kTile; ++r) first[r + 1] += first[r];
  by_row.resize(first[Lens::kTile]);
  std::uint32_t next[Lens::kTile];
  std::copy_n(first, Lens::kTile, next);
  for (std::uint32_t i = 0; i < seen_by.size(); ++i)
    for (std::uint32_t rows = seen_by[i].rows; rows != 0; rows &= rows - 1)
      by_row[next[std::countr_zero(rows)]++] = {i, seen_by[i].columns};
}

}  // namespace kestrel::sim::ray
