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
  std::vector<int> opaque, transparent;  // of the opaque, those of triangles last: what is before them spares
                                         // most of the search
  bool thin = false;                     // some are so thin that a pixel's ray may miss them
};

void ListSeen(const Slice& slice, int tile_column, Seen& seen) {
  seen.opaque.clear();
  seen.transparent.clear();
  seen.thin = false;
  const std::uint64_t* words = slice.visible + static_cast<std::ptrdiff_t>(tile_column) * slice.words;
  for (int w = 0; w < slice.words; ++w) {
    for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
      const int i = 64 * w + std::countr_zero(bits);
      if (slice.placement->things[i].transparent) continue;
      seen.opaque.push_back(i);
      seen.thin = seen.thin || slice.placement->things[i].thin;
    }
  }
  for (std::size_t last = seen.opaque.size(), k = 0; k < last;) {
    if (slice.things->all[seen.opaque[k]].triangles)
      std::rotate(seen.opaque.begin() + k, seen.opaque.begin() + k + 1, seen.opaque.end()), --last;
    else
      ++k;
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

HWY_INLINE Hit Trace(const Slice& slice, const Seen& seen, const Vec3& d_C, TriangleHits& triangles) {
  Hit hit{F(kNone), hn::Set(di, -1)};
  for (const int i : seen.opaque) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    TriangleHits own;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, d_C), hit.t, own);
    const MF nearer = hn::Lt(t, hit.t);
    hit.t = hn::IfThenElse(nearer, t, hit.t);
    hit.thing = hn::IfThenElse(hn::RebindMask(di, nearer), hn::Set(di, i), hit.thing);
    if (thing.triangles) Keep(nearer, own, triangles);
  }
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
