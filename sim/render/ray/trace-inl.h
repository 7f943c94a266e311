// SPDX-License-Identifier: Apache-2.0
// What the rays of a packet meet of the things that their tile may see.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_TRACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_TRACE_INL_H_
#undef KESTREL_SIM_RAY_TRACE_INL_H_
#else
#define KESTREL_SIM_RAY_TRACE_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <vector>

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/shapes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

// The things that a tile may see.
struct Seen {
  std::vector<int> opaque, transparent;      // of the opaque, all but those of triangles
  const TileTriangles* triangles = nullptr;  // of what is opaque
  bool thin = false;                         // some are so thin that a pixel's ray may miss them
};

void ListSeen(const Slice& slice, int tile_column, Seen& seen) {
  seen.triangles = slice.triangles + tile_column;
  seen.opaque.clear();
  seen.transparent.clear();
  seen.thin = false;
  const std::uint64_t* words = slice.visible + static_cast<std::ptrdiff_t>(tile_column) * slice.words;
  for (int w = 0; w < slice.words; ++w) {
    for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
      const int i = 64 * w + std::countr_zero(bits);
      if (slice.placement->things[i].transparent) continue;
      if (slice.things->all[i].triangles) continue;
      seen.opaque.push_back(i);
      seen.thin = seen.thin || slice.placement->things[i].thin;
    }
  }
  for (const int i : slice.placement->transparent) {
    if (!(words[i / 64] >> (i % 64) & 1)) continue;
    seen.transparent.push_back(i);
    seen.thin = seen.thin || slice.placement->things[i].thin;
  }
}

// Where the mask is, `to` becomes `from`.
HWY_INLINE void Keep(MF where, const TriangleHits& from, TriangleHits& to) {
  const auto keep = [&](const auto& a, auto& b, auto d) {
    hn::Store(hn::IfThenElse(hn::RebindMask(d, where), hn::Load(d, a), hn::Load(d, b)), d, b);
  };
  const hn::RebindToUnsigned<DF> du;
  keep(from.face, to.face, du);
  keep(from.u, to.u, df);
  keep(from.v, to.v, df);
}

// What of the triangles of some pixels of the tile the rays meet before the hit.
HWY_INLINE void MeetTriangles(const TileTriangles& triangles, const TilePixels& of, const Vec3& d, Hit& hit,
                              TriangleHits& hits) {
  VF u = hn::Zero(df), v = hn::Zero(df);
  VI face = hn::Zero(di);
  MF any = hn::Lt(F(1), F(0));
  VF nearest = hn::Min(hit.t, F(kFar));
  for (std::uint32_t rows = of.rows; rows != 0; rows &= rows - 1) {
    const int row = std::countr_zero(rows);
    constexpr std::uint32_t kAtOnce = 64;
    for (std::uint32_t first = triangles.first[row], end = triangles.first[row + 1]; first < end;
         first += kAtOnce) {
      // Those of the columns, without a branch that cannot be foreseen.
      std::uint32_t near[kAtOnce], count = 0;
      for (std::uint32_t i = first; i < std::min(first + kAtOnce, end); ++i) {
        near[count] = triangles.by_row[i].index;
        count += (triangles.by_row[i].columns & of.columns) != 0;
      }
      for (std::uint32_t i = 0; i < count; ++i) {
        const TileTriangle& triangle = triangles.all[near[i]];
        const VF a = Dot(Load3(triangle.edge[0]), d), b = Dot(Load3(triangle.edge[1]), d),
                 c = Dot(Load3(triangle.edge[2]), d);
        const MF inside = hn::Ge(hn::Min(a, hn::Min(b, c)), hn::Zero(df));
        if (hn::AllFalse(df, inside)) continue;
        const VF inverse = hn::Div(F(1), Dot(Load3(triangle.normal), d));
        const VF t = hn::Mul(F(triangle.height), inverse);
        const MF nearer = hn::And(inside, hn::And(hn::Gt(t, hn::Zero(df)), hn::Lt(t, nearest)));
        if (hn::AllFalse(df, nearer)) continue;
        any = hn::Or(any, nearer);
        nearest = hn::IfThenElse(nearer, t, nearest);
        // An edge's dot products are minus twice the corner's share of the normal's.
        const VF share = hn::Mul(F(-0.5f), inverse);
        u = hn::IfThenElse(nearer, hn::Mul(b, share), u);
        v = hn::IfThenElse(nearer, hn::Mul(c, share), v);
        const auto is = hn::RebindMask(di, nearer);
        face = hn::IfThenElse(is, hn::Set(di, static_cast<std::int32_t>(triangle.face)), face);
        hit.thing = hn::IfThenElse(is, hn::Set(di, triangle.thing), hit.thing);
      }
    }
  }
  if (hn::AllFalse(df, any)) return;
  hit.t = hn::IfThenElse(any, nearest, hit.t);
  hn::Store(hn::BitCast(hn::RebindToUnsigned<DF>(), face), hn::RebindToUnsigned<DF>(), hits.face);
  hn::Store(u, df, hits.u);
  hn::Store(v, df, hits.v);
}

HWY_INLINE TilePixels OnePixel(int u, int v) { return {1u << (v % Lens::kTile), 1u << (u % Lens::kTile)}; }
HWY_INLINE TilePixels OneRow(int v) { return {1u << (v % Lens::kTile), ~0u}; }

// pixels: those that the rays are of.
HWY_INLINE Hit Trace(const Slice& slice, const Seen& seen, const TilePixels& pixels, const Vec3& d_C,
                     TriangleHits& triangles) {
  Hit hit{F(kNone), hn::Set(di, -1)};
  for (const int i : seen.opaque) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    TriangleHits unused;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, d_C), hit.t, unused);
    const MF nearer = hn::Lt(t, hit.t);
    hit.t = hn::IfThenElse(nearer, t, hit.t);
    hit.thing = hn::IfThenElse(hn::RebindMask(di, nearer), hn::Set(di, i), hit.thing);
  }
  if (!seen.triangles->all.empty()) MeetTriangles(*seen.triangles, pixels, d_C, hit, triangles);
  return hit;
}

HWY_INLINE Rays RaysAt(const Lens& lens, std::ptrdiff_t at) {
  const auto load = [&](std::ptrdiff_t i) {
    return Vec3{hn::LoadU(df, lens.x.get() + i), hn::LoadU(df, lens.y.get() + i),
                hn::LoadU(df, lens.z.get() + i)};
  };
  Rays rays;
  rays.d = load(at);
  rays.du = load(at + 1) - rays.d;
  rays.dv = load(at + lens.stride) - rays.d;
  return rays;
}

HWY_INLINE MF InsideAt(const Lens& lens, std::ptrdiff_t at) {
  const hn::Rebind<std::uint8_t, DF> d8;
  return hn::RebindMask(df, hn::Ne(hn::PromoteTo(di, hn::LoadU(d8, lens.inside.get() + at)), hn::Zero(di)));
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
