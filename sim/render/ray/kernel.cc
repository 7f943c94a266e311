// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "sim/render/ray/instruction_targets.h"  // before Highway
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/render/ray/kernel.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "sim/render/ray/look-inl.h"
#include "sim/render/ray/smooth-inl.h"
#include "sim/render/ray/surface-inl.h"
#include "sim/render/ray/tile_triangles-inl.h"
#include "sim/render/ray/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

// Rays that pass so near a thin thing that it covers part of their pixel.
MF NearThin(const Slice& slice, const Seen& seen, const Vec3& d) {
  MF near = hn::Lt(F(1), F(0));
  TriangleHits unused;
  const auto add = [&](int i) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    if (!placed.thin) return;
    const float room = slice.lens->pixel_rad * (placed.distance + thing.box_half.norm());
    const Eigen::Vector3f wider = thing.size + Eigen::Vector3f::Constant(room);
    near = hn::Or(
        near, hn::Lt(Enter(thing, wider, Load3(placed.o), Rotate(placed.R, d), F(kFar), unused), F(kFar)));
  };
  for (const int i : seen.opaque) add(i);
  for (const int i : seen.transparent) add(i);
  return near;
}

const char* Name() { return hwy::TargetName(HWY_TARGET); }

void CullImpl(const Slice& slice, int begin, int end) {
  const Lens& lens = *slice.lens;
  const int tile_row = begin / Lens::kTile;
  std::fill(slice.visible, slice.visible + static_cast<std::ptrdiff_t>(lens.tiles_x) * slice.words, 0);
  const int first = tile_row * lens.tiles_x;
  for (int c = 0; c < lens.tiles_x; ++c) slice.triangles[c].Clear();
  for (std::size_t i = 0; i < slice.things->all.size(); ++i) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    for (int c = 0; c < lens.tiles_x; c += kLanes) {
      const auto load = [&](const Aligned<float>& v) { return hn::LoadU(df, v.get() + first + c); };
      const Vec3 axis{load(lens.axis_x), load(lens.axis_y), load(lens.axis_z)};
      const MF may =
          MayMeet(thing.box_centre, thing.box_half, placed, Rotate(placed.R, axis), load(lens.reach));
      for (std::uint32_t bits = BitsOf(may); bits != 0; bits &= bits - 1) {
        const int column = c + std::countr_zero(bits);
        if (column >= lens.tiles_x) break;
        slice.visible[static_cast<std::ptrdiff_t>(column) * slice.words +
                      static_cast<std::ptrdiff_t>(i / 64)] |= std::uint64_t{1} << (i % 64);
        if (thing.triangles && !placed.transparent)
          ListTriangles(slice, first + column, begin % Lens::kTile, begin % Lens::kTile + end - begin,
                        static_cast<int>(i), slice.triangles[column]);
      }
    }
  }
  for (int c = 0; c < lens.tiles_x; ++c) slice.triangles[c].SortByRow();
}

// A packet of a row that shows one thing alone, planned but not yet fetched.
struct Job {
  Surface surface;
  alignas(64) std::int32_t mixed[4 * kLanes];
  MF inside;
  VF contrast;
  Veil veil;
  bool hazed = false, veiled = false;
  int u = 0, pixels = 0;
};

// Of the row v from u on.
HWY_INLINE void StorePixels(const Colours& colour, MF inside, int pixels, const Canvas& canvas, int v,
                            int u) {
  if (canvas.grey) {
    const VF grey = hn::IfThenElseZero(inside, GreyOf(colour));
    float* const to = canvas.grey + v * canvas.step + u;
    if (pixels >= kLanes) return hn::StoreU(grey, df, to);
    alignas(64) float last[kLanes];
    hn::Store(grey, df, last);
    std::memcpy(to, last, sizeof(float) * static_cast<std::size_t>(pixels));
    return;
  }
  std::uint8_t* const to = canvas.bgr + v * canvas.step + 3 * static_cast<std::size_t>(u);
  const hn::Rebind<std::uint8_t, DF> d8;
  const auto bytes = [&](VF c) {
    return hn::U8FromU32(hn::BitCast(hn::RebindToUnsigned<DF>(), Rounded(hn::IfThenElseZero(inside, c))));
  };
  if (pixels >= kLanes)
    return hn::StoreInterleaved3(bytes(colour.b), bytes(colour.g), bytes(colour.r), d8, to);
  std::uint8_t last[3 * kLanes + 16];
  hn::StoreInterleaved3(bytes(colour.b), bytes(colour.g), bytes(colour.r), d8, last);
  std::memcpy(to, last, 3 * static_cast<std::size_t>(pixels));
}

void StoreNothing(int pixels, const Canvas& canvas, int v, int u) {
  if (canvas.grey) {
    std::fill_n(canvas.grey + v * canvas.step + u, pixels, 0.0f);
  } else {
    std::memset(canvas.bgr + v * canvas.step + 3 * static_cast<std::size_t>(u), 0,
                3 * static_cast<std::size_t>(pixels));
  }
}

void DrawRowsImpl(const Slice& slice, int begin, int end, const Canvas& canvas) {
  const Lens& lens = *slice.lens;
  const Air& air = slice.things->air;
  const int tile_row = begin / Lens::kTile;
  // Kept from call to call: to ask for memory thousands of times a frame costs.
  static thread_local std::vector<Seen> kept_seen;
  static thread_local std::vector<Job> kept_jobs;
  std::vector<Seen>& seen = kept_seen;
  std::vector<Job>& jobs = kept_jobs;
  seen.resize(lens.tiles_x);
  jobs.resize(static_cast<std::size_t>(lens.tiles_x) * (Lens::kTile / kLanes));
  for (int column = 0; column < lens.tiles_x; ++column) ListSeen(slice, column, seen[column]);
  // Row by row, as the table and the image lie in memory.
  for (int v = begin; v < end; ++v) {
    int planned = 0;
    for (int column = 0; column < lens.tiles_x; ++column) {
      const int u0 = column * Lens::kTile;
      std::uint32_t* codes = canvas.code + static_cast<std::ptrdiff_t>(v) * lens.stride + u0;
      std::uint32_t& common = canvas.common[static_cast<std::ptrdiff_t>(v) * lens.tiles_x + column];
      common = Canvas::kMixed;
      if (lens.reach[tile_row * lens.tiles_x + column] < 0) {
        StoreNothing(std::min(Lens::kTile, lens.width - u0), canvas, v, u0);
        std::fill(codes, codes + Lens::kTile, kOutside);
        common = kOutside;
        continue;
      }
      const Seen& here = seen[column];
      auto differ = hn::Ne(hn::Zero(di), hn::Zero(di));
      VI reference = hn::Zero(di);
      for (int k = 0; k < Lens::kTile && u0 + k < lens.width; k += kLanes) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(v) * lens.stride + u0 + k;
        const int pixels = std::min(kLanes, lens.width - u0 - k);
        const MF inside = InsideAt(lens, at);
        if (hn::AllFalse(df, inside)) {
          StoreNothing(pixels, canvas, v, u0 + k);
          std::fill(codes + k, codes + k + kLanes, kOutside);
          continue;
        }
        const Rays rays = RaysAt(lens, at);
        TriangleHits triangles;
        Hit hit = Trace(slice, here, OneRow(v), rays.d, triangles);
        EndPlane(slice, rays.d, hit);
        VI code;
        alignas(64) std::int32_t index[kLanes];
        hn::Store(hit.thing, di, index);
        const int first = index[hn::FindFirstTrue(df, inside)];
        const bool alone = hn::AllTrue(
            df, hn::Or(hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, first))), hn::Not(inside)));
        if (alone && slice.things->haze.thing < 0) {
          Job& job = jobs[planned++];
          ShadeHit(slice, first, rays, hit.t, triangles, inside, job.surface);
          job.inside = inside;
          job.hazed = air.per_m > 0 && first >= 0;
          if (job.hazed) job.contrast = ContrastAt(air, rays.d, hit.t);
          job.u = u0 + k;
          job.pixels = pixels;
          code = CodeOf(job.surface.side, first);
          job.veiled = !here.transparent.empty();
          if (job.veiled) {
            job.veil = VeilOf(slice, here, rays, hit.t, inside);
            job.veiled = !hn::AllFalse(df, job.veil.any);
            code = hn::Add(code, job.veil.mark);
          }
          code = hn::And(code, hn::Set(di, 0x3fffffff));
        } else {
          const Picture picture = Look(slice, here, rays, hit, triangles, inside);
          StorePixels(picture.colour, inside, pixels, canvas, v, u0 + k);
          code = picture.code;
        }
        code = hn::IfThenElse(hn::RebindMask(di, inside), code,
                              hn::Set(di, static_cast<std::int32_t>(kOutside)));
        if (here.thin) {
          const MF always = hn::And(inside, NearThin(slice, here, rays.d));
          code = hn::Or(code, hn::IfThenElseZero(hn::RebindMask(di, always),
                                                 hn::Set(di, static_cast<std::int32_t>(kAlwaysSmooth))));
        }
        hn::StoreU(code, di, reinterpret_cast<std::int32_t*>(codes + k));
        if (k == 0) reference = hn::Set(di, hn::GetLane(code));
        differ = hn::Or(differ, hn::Ne(code, reference));
      }
      if (hn::AllFalse(di, differ)) common = codes[0];
    }
    for (int i = 0; i < planned; ++i)
      if (jobs[i].surface.fetch.picture) Mix(jobs[i].surface.fetch, jobs[i].mixed);
    for (int i = 0; i < planned; ++i) {
      const Job& job = jobs[i];
      const Colours& lit = job.surface.lit;
      Colours colour = job.surface.fetch.picture ? Tinted(lit, job.mixed) : lit;
      if (job.hazed) colour = ThroughAir(air, job.contrast, colour);
      if (job.veiled) colour = Through(job.veil, colour);
      StorePixels(colour, job.inside, job.pixels, canvas, v, job.u);
    }
  }
}

void SeeRowsImpl(const Slice& slice, int begin, int end, float* depth_m, std::int32_t* geom,
                 std::size_t stride) {
  const Lens& lens = *slice.lens;
  Seen seen;
  for (int column = 0; column < lens.tiles_x; ++column) {
    const int u0 = column * Lens::kTile;
    ListSeen(slice, column, seen);
    for (int v = begin; v < end; ++v) {
      for (int k = 0; k < Lens::kTile && u0 + k < lens.width; k += kLanes) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(v) * lens.stride + u0 + k;
        const Rays rays = RaysAt(lens, at);
        TriangleHits unused;
        Hit hit = Trace(slice, seen, OneRow(v), rays.d, unused);
        EndPlane(slice, rays.d, hit);
        alignas(64) float t[kLanes];
        alignas(64) std::int32_t thing[kLanes];
        hn::Store(hn::Mul(hit.t, LengthOf(rays.d)), df, t);
        hn::Store(hit.thing, di, thing);
        for (int i = 0; i < kLanes && u0 + k + i < lens.width; ++i) {
          const std::size_t to = v * stride + u0 + k + i;
          const bool inside = lens.inside[at + i];
          depth_m[to] = inside ? t[i] : std::numeric_limits<float>::quiet_NaN();
          geom[to] = !inside ? -2 : thing[i] < 0 ? -1 : slice.things->all[thing[i]].geom;
        }
      }
    }
  }
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kestrel::sim::ray {

HWY_EXPORT(Name);
HWY_EXPORT(CullImpl);
HWY_EXPORT(DrawRowsImpl);
HWY_EXPORT(SmoothRowsImpl);
HWY_EXPORT(SeeRowsImpl);

const char* InstructionSet() { return HWY_DYNAMIC_DISPATCH(Name)(); }
void Cull(const Slice& slice, int begin, int end) { HWY_DYNAMIC_DISPATCH(CullImpl)(slice, begin, end); }
void DrawRows(const Slice& slice, int begin, int end, const Canvas& canvas) {
  HWY_DYNAMIC_DISPATCH(DrawRowsImpl)(slice, begin, end, canvas);
}
void SmoothRows(const Slice& slice, int begin, int end, const Canvas& canvas) {
  HWY_DYNAMIC_DISPATCH(SmoothRowsImpl)(slice, begin, end, canvas);
}
void TraceRows(const Slice& slice, int begin, int end, float* depth_m, std::int32_t* geom,
               std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(SeeRowsImpl)(slice, begin, end, depth_m, geom, stride);
}

}  // namespace kestrel::sim::ray
#endif
