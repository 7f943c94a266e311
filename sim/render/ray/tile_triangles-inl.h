// SPDX-License-Identifier: Apache-2.0
// The triangles that the rays of a tile may meet, drawn as a rasteriser does, though by rays: whether a ray passes a
// triangle is told by the planes through the viewpoint and its edges, which is exact for every lens.
// (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997.)
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_TILE_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_TILE_TRIANGLES_INL_H_
#undef KESTREL_SIM_RAY_TILE_TRIANGLES_INL_H_
#else
#define KESTREL_SIM_RAY_TILE_TRIANGLES_INL_H_
#endif

#include <bit>
#include <cmath>
#include <vector>

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/shapes-inl.h"
#include "sim/render/ray/tile_triangles.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

// A tile of the picture, or a row of it.
struct Part {
  const Lens::Plane* plane;
  float low_y, high_y;
  std::uint32_t rows;  // a bit for each
  float R[9], o[3];    // of the thing: a point p in its frame is at R (p - o) across, down and along the axis
  // In the thing's frame: all that the part shows is at side (p - o) <= 0, of its four sides and of what is behind.
  float side[5][3];
};

// Which of sixteen boxes the part may show, a bit for each.
HWY_INLINE std::uint32_t MayShow(const Part& part, const TriangleBlocks::Boxes& boxes) {
  std::uint32_t bits = 0;
  for (int i = 0; i < TriangleBlocks::kWidth; i += kLanes) {
    const auto load = [&](const float(&of)[3][TriangleBlocks::kWidth]) {
      return Vec3{hn::Load(df, of[0] + i), hn::Load(df, of[1] + i), hn::Load(df, of[2] + i)};
    };
    const Vec3 centre = load(boxes.centre) - Load3(part.o), half = load(boxes.half);
    MF may = hn::Ge(half.x, hn::Zero(df));
    for (const auto& side : part.side) {
      if (!part.plane->bounded) break;
      const float widest[3] = {std::abs(side[0]), std::abs(side[1]), std::abs(side[2])};
      may = hn::And(may, hn::Le(Dot(Load3(side), centre), Dot(Load3(widest), half)));
    }
    bits |= BitsOf(may) << i;
  }
  return bits;
}

// The most of n d for the directions d = (x, y, 1) with x and y between low and high.
HWY_INLINE VF Most(const Vec3& n, float low_x, float high_x, float low_y, float high_y) {
  return hn::Add(n.z, hn::Add(hn::Max(hn::Mul(n.x, F(low_x)), hn::Mul(n.x, F(high_x))),
                              hn::Max(hn::Mul(n.y, F(low_y)), hn::Mul(n.y, F(high_y)))));
}

// Which rows of a tile may see a triangle by the edges' normals and the lowest and the highest of it, in the tile's
// plane.
HWY_INLINE std::uint32_t RowsOf(const Lens::Plane& plane, const float (*edge)[3], float low, float high) {
  if (!plane.bounded) return ~0u;
  std::uint32_t rows = 0;
  for (int r = 0; r < Lens::kTile; r += kLanes)
    rows |= BitsOf(hn::And(hn::Le(F(low), hn::LoadU(df, plane.row_high_y + r)),
                           hn::Ge(F(high), hn::LoadU(df, plane.row_low_y + r))))
            << r;
  if (std::popcount(rows) < 4)
    return rows;  // as of most that are far: a closer look would cost more than it spares
  std::uint32_t passed = 0;
  float most_x[3];  // of x and 1
  for (int k = 0; k < 3; ++k)
    most_x[k] = edge[k][2] + std::max(edge[k][0] * plane.low_x, edge[k][0] * plane.high_x);
  for (int r = 0; r < Lens::kTile; r += kLanes) {
    const VF low_y = hn::LoadU(df, plane.row_low_y + r), high_y = hn::LoadU(df, plane.row_high_y + r);
    MF may = hn::Ge(hn::Zero(df), hn::Zero(df));
    for (int k = 0; k < 3; ++k) {
      const VF most =
          hn::Add(F(most_x[k]), hn::Max(hn::Mul(F(edge[k][1]), low_y), hn::Mul(F(edge[k][1]), high_y)));
      may = hn::And(may, hn::Ge(most, hn::Zero(df)));
    }
    passed |= BitsOf(may) << r;
  }
  return rows & passed;
}

HWY_INLINE std::uint32_t ColumnsOf(const Lens::Plane& plane, float low, float high) {
  if (!plane.bounded) return ~0u;
  std::uint32_t columns = 0;
  for (int c = 0; c < Lens::kTile; c += kLanes) {
    const VF low_x = hn::LoadU(df, plane.column_low_x + c), high_x = hn::LoadU(df, plane.column_high_x + c);
    columns |= BitsOf(hn::And(hn::Le(F(low), high_x), hn::Ge(F(high), low_x))) << c;
  }
  return columns;
}

// Adds of a block what the part of the picture may show.
void AddBlock(const Part& part, int thing, const TriangleBlocks::Block& block, TileTriangles& to) {
  const Lens::Plane& plane = *part.plane;
  const VF zero = hn::Zero(df);
  for (int i = 0; i < TriangleBlocks::kWidth; i += kLanes) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 at{hn::Load(df, block.corner[k][0] + i), hn::Load(df, block.corner[k][1] + i),
                    hn::Load(df, block.corner[k][2] + i)};
      corner[k] = Rotate(part.R, at - Load3(part.o));
    }
    // Not wholly behind, nor to one side. What reaches behind the viewpoint has no bounds in the plane.
    VF low_x = F(kNone), high_x = F(-kNone), low_y = low_x, high_y = high_x, nearest = low_x,
       farthest = high_x;
    for (const Vec3& c : corner) {
      const VF inverse = hn::Div(F(1), c.z), x = hn::Mul(c.x, inverse), y = hn::Mul(c.y, inverse);
      low_x = hn::Min(low_x, x), high_x = hn::Max(high_x, x), low_y = hn::Min(low_y, y),
      high_y = hn::Max(high_y, y);
      nearest = hn::Min(nearest, c.z), farthest = hn::Max(farthest, c.z);
    }
    const MF bounded = hn::Gt(nearest, zero);
    const auto or_all = [&](VF bound, float all) { return hn::IfThenElse(bounded, bound, F(all)); };
    low_x = or_all(low_x, -kNone), high_x = or_all(high_x, kNone);
    low_y = or_all(low_y, -kNone), high_y = or_all(high_y, kNone);
    MF may = hn::And(hn::And(hn::Le(low_x, F(plane.high_x)), hn::Ge(high_x, F(plane.low_x))),
                     hn::And(hn::Le(low_y, F(part.high_y)), hn::Ge(high_y, F(part.low_y))));
    may = hn::And(may, hn::Gt(farthest, zero));
    const MF anywhere = hn::Eq(F(plane.bounded ? 1 : 0), zero);
    may = hn::Or(may, anywhere);
    if (hn::AllFalse(df, may)) continue;
    const Vec3 normal = Cross(corner[1] - corner[0], corner[2] - corner[0]);
    const VF height = Dot(normal, corner[0]);
    may = hn::And(may, hn::Lt(height, zero));
    Vec3 edge[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 &from = corner[(k + 1) % 3], &end = corner[(k + 2) % 3];
      edge[k] = Cross(end - from, from + end);
      const VF most = Most(edge[k], plane.low_x, plane.high_x, part.low_y, part.high_y);
      may = hn::And(may, hn::Or(anywhere, hn::Ge(most, zero)));
    }
    std::uint32_t bits = BitsOf(may);
    if (bits == 0) continue;
    alignas(64) float lanes[26][kLanes];
    const auto put = [&](const Vec3& v, int first) {
      hn::Store(v.x, df, lanes[first]), hn::Store(v.y, df, lanes[first + 1]),
          hn::Store(v.z, df, lanes[first + 2]);
    };
    // From the tile's frame into C.
    const auto turned = [&](const Vec3& v) {
      return Along(Along(Scale(Load3(plane.across), v.x), v.y, Load3(plane.down)), v.z, Load3(plane.axis));
    };
    for (int k = 0; k < 3; ++k) put(turned(edge[k]), 3 * k), put(edge[k], 13 + 3 * k);
    put(turned(normal), 9);
    hn::Store(height, df, lanes[12]);
    hn::Store(low_x, df, lanes[22]), hn::Store(high_x, df, lanes[23]);
    hn::Store(low_y, df, lanes[24]), hn::Store(high_y, df, lanes[25]);
    for (; bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      float in_plane[3][3];
      for (int k = 0; k < 9; ++k) in_plane[k / 3][k % 3] = lanes[13 + k][lane];
      const std::uint32_t rows = RowsOf(plane, in_plane, lanes[24][lane], lanes[25][lane]) & part.rows;
      if (rows == 0) continue;
      TileTriangle triangle;
      for (int k = 0; k < 9; ++k) triangle.edge[k / 3][k % 3] = lanes[k][lane];
      for (int k = 0; k < 3; ++k) triangle.normal[k] = lanes[9 + k][lane];
      triangle.height = lanes[12][lane];
      triangle.face = block.face[i + lane];
      triangle.thing = thing;
      to.Add(triangle, {rows, ColumnsOf(plane, lanes[22][lane], lanes[23][lane])});
    }
  }
}

// Adds those of a thing that rays of the tile's rows begin to end - 1 may meet.
void ListTriangles(const Slice& slice, int tile, int begin, int end, int thing, TileTriangles& to) {
  const Lens& lens = *slice.lens;
  const Lens::Plane& plane = lens.planes[static_cast<std::size_t>(tile)];
  const GeomInstance& placed = slice.placement->things[thing];
  const TriangleBlocks& from = slice.things->all[thing].triangles->blocks;
  if (lens.reach[tile] < 0 || from.levels.empty()) return;
  Part part{&plane, 1e9f, -1e9f, ((1u << end) - 1) & ~((1u << begin) - 1), {}, {}, {}};
  for (int r = begin; r < end; ++r) {
    part.low_y = std::min(part.low_y, plane.row_low_y[r]);
    part.high_y = std::max(part.high_y, plane.row_high_y[r]);
  }
  const float* const axes[3] = {plane.across, plane.down, plane.axis};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) part.R[3 * r + c] += axes[r][k] * placed.R[3 * c + k];
  for (int k = 0; k < 3; ++k) {
    const float across = part.R[k], down = part.R[3 + k], along = part.R[6 + k];
    part.o[k] = placed.o[k];
    part.side[0][k] = across - plane.high_x * along, part.side[1][k] = plane.low_x * along - across;
    part.side[2][k] = down - part.high_y * along, part.side[3][k] = part.low_y * along - down;
    part.side[4][k] = -along;
  }
  struct Group {
    std::size_t level, index;
  };
  static thread_local std::vector<Group> left;
  left.assign(1, {from.levels.size() - 1, 0});
  while (!left.empty()) {
    const Group group = left.back();
    left.pop_back();
    const TriangleBlocks::Boxes& boxes = from.levels[group.level][group.index];
    for (std::uint32_t bits = MayShow(part, boxes); bits != 0; bits &= bits - 1) {
      const std::size_t index =
          TriangleBlocks::kWidth * group.index + static_cast<std::size_t>(std::countr_zero(bits));
      if (group.level > 0)
        left.push_back({group.level - 1, index});
      else
        AddBlock(part, thing, from.blocks[index], to);
    }
  }
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
