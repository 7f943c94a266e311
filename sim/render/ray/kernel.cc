// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

// Compiled once for each of AVX-512, AVX2 and SSSE3, and not for what lies between or has yet more: the better, the
// lower its bit.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | (HWY_AVX3 - 1))
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/render/ray/kernel.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "sim/render/ray/surface-inl.h"
#include "sim/render/ray/tile_triangles-inl.h"
#include "sim/render/ray/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

constexpr std::uint32_t kOutside = 0x7fffffff;  // codes of a pixel
constexpr std::uint32_t kAlwaysSmooth = 0x80000000;

// Which rays meet something transparent before what they hit.
HWY_INLINE MF Veiled(const Slice& slice, const Seen& seen, const Vec3& d_C, VF t) {
  MF veiled = hn::Lt(F(1), F(0));
  TriangleHits unused;
  for (const int i : seen.transparent) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    const VF entry = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, d_C), t, unused);
    veiled = hn::Or(veiled, hn::Lt(entry, t));
  }
  return veiled;
}

struct Picture {
  Colours colour;
  VI code;
};

// Shades what is opaque, or the sky (index -1).
HWY_INLINE void ShadeHit(const Slice& slice, int index, const Rays& rays, VF t, const TriangleHits& triangles,
                         MF wanted, Surface& surface) {
  if (index < 0) return ShadeSky(slice, rays, wanted, surface);
  Shade(slice, index, rays, t, triangles, wanted, surface);
}

HWY_INLINE VI SideOf(const Slice& slice, int index, const Vec3& d_C, VF t, const TriangleHits& triangles,
                     MF wanted) {
  const Geom& thing = slice.things->all[index];
  if (thing.type == mjGEOM_PLANE || thing.type == mjGEOM_SPHERE || thing.type == mjGEOM_ELLIPSOID ||
      thing.type == mjGEOM_CAPSULE)
    return hn::Zero(di);
  const GeomInstance& placed = slice.placement->things[index];
  const VF far = hn::IfThenElse(wanted, t, F(1));
  Vec3 normal;
  VI side;
  const Vec3 d = Rotate(placed.R, d_C);
  NormalOf(thing, Along(Load3(placed.o), far, d), triangles, wanted, normal, side);
  return thing.triangles ? hn::Or(side, LeapOf(normal, Scale(d, far))) : side;
}

HWY_INLINE VI CodeOf(VI side, int index) { return hn::Add(hn::ShiftLeft<12>(side), hn::Set(di, index + 1)); }

// Colours of a packet: what is opaque, the sky behind, haze, what is transparent.
HWY_NOINLINE Picture Look(const Slice& slice, const Seen& seen, const Rays& rays, const Hit& hit,
                          const TriangleHits& triangles, MF wanted) {
  Picture picture{{hn::Zero(df), hn::Zero(df), hn::Zero(df)}, hn::Zero(di)};
  const Air& air = slice.things->air;
  alignas(64) std::int32_t index[kLanes];
  hn::Store(hit.thing, di, index);
  Surface surface;
  MF left = wanted;
  while (!hn::AllFalse(df, left)) {
    const int i = index[hn::FindFirstTrue(df, left)];
    const MF here = hn::And(left, hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, i))));
    left = hn::AndNot(here, left);
    ShadeHit(slice, i, rays, hit.t, triangles, here, surface);
    Colours c = Finish(surface);
    if (air.per_m > 0 && i >= 0) c = ThroughAir(air, ContrastAt(air, rays.d, hit.t), c);
    picture.colour = {hn::IfThenElse(here, c.r, picture.colour.r),
                      hn::IfThenElse(here, c.g, picture.colour.g),
                      hn::IfThenElse(here, c.b, picture.colour.b)};
    picture.code = hn::IfThenElse(hn::RebindMask(di, here), CodeOf(surface.side, i), picture.code);
  }
  if (slice.things->haze.thing >= 0) picture.colour = Hazed(slice, rays, hit.t, picture.colour);

  // As MuJoCo draws them: all from front to back, then all from back to front.
  struct Layer {
    alignas(64) float r[kLanes], g[kLanes], b[kLanes], alpha[kLanes];
  };
  static thread_local std::vector<Layer> kept;
  std::vector<Layer>& layers = kept;
  layers.clear();
  for (const int i : seen.transparent) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    TriangleHits own;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, rays.d), hit.t, own);
    const MF here = hn::And(wanted, hn::Lt(t, hit.t));
    if (hn::AllFalse(df, here)) continue;
    Shade(slice, i, rays, t, own, here, surface);
    const Colours c = Finish(surface);
    Layer& layer = layers.emplace_back();
    hn::Store(c.r, df, layer.r), hn::Store(c.g, df, layer.g), hn::Store(c.b, df, layer.b);
    hn::Store(hn::IfThenElseZero(here, F(placed.alpha)), df, layer.alpha);
    const VI mark = hn::Set(di, static_cast<std::int32_t>(2 * ((i + 1) * 0x9e3779b1u & 0x0fffffff)));
    picture.code = hn::Add(picture.code, hn::IfThenElseZero(hn::RebindMask(di, here), mark));
  }
  const std::size_t count = layers.size();
  for (std::size_t k = 0; k < 2 * count; ++k) {
    const Layer& l = layers[k < count ? k : 2 * count - 1 - k];
    const Colours c{hn::Load(df, l.r), hn::Load(df, l.g), hn::Load(df, l.b)};
    picture.colour = Over(c, hn::Load(df, l.alpha), picture.colour, wanted);
  }
  picture.code = hn::And(picture.code, hn::Set(di, 0x3fffffff));
  return picture;
}

// Of a colour, which is in 0 to 255 by its making.
HWY_INLINE VI Rounded(VF colour) { return hn::NearestInt(colour); }

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
  bool hazed = false;
  int u = 0, pixels = 0;
};

// The weights of ITU-R BT.601, as OpenCV's conversion to grey has them.
HWY_INLINE VF GreyOf(const Colours& c) {
  return hn::MulAdd(c.r, F(0.299f), hn::MulAdd(c.g, F(0.587f), hn::Mul(c.b, F(0.114f))));
}

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
        if (alone && slice.things->haze.thing < 0 &&
            hn::AllFalse(df, hn::And(inside, Veiled(slice, here, rays.d, hit.t)))) {
          Job& job = jobs[planned++];
          ShadeHit(slice, first, rays, hit.t, triangles, inside, job.surface);
          job.inside = inside;
          job.hazed = air.per_m > 0 && first >= 0;
          if (job.hazed) job.contrast = ContrastAt(air, rays.d, hit.t);
          job.u = u0 + k;
          job.pixels = pixels;
          code = hn::And(CodeOf(job.surface.side, first), hn::Set(di, 0x3fffffff));
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
      if (jobs[i].surface.fetch.texels) Mix(jobs[i].surface.fetch, jobs[i].mixed);
    for (int i = 0; i < planned; ++i) {
      const Job& job = jobs[i];
      const Colours& lit = job.surface.lit;
      Colours colour = job.surface.fetch.texels ? Tinted(lit, job.mixed) : lit;
      if (job.hazed) colour = ThroughAir(air, job.contrast, colour);
      StorePixels(colour, job.inside, job.pixels, canvas, v, job.u);
    }
  }
}

// Eight places in a pixel, each in a column and a row of its own, the nearest to the middle first.
constexpr int kSubpixels = 8;
alignas(64) constexpr float kAcross[kSubpixels] = {1 / 16.f,  -1 / 16.f, 5 / 16.f, -3 / 16.f,
                                                   -5 / 16.f, -7 / 16.f, 3 / 16.f, 7 / 16.f};
alignas(64) constexpr float kDown[kSubpixels] = {-3 / 16.f, 3 / 16.f,  1 / 16.f, -5 / 16.f,
                                                 5 / 16.f,  -1 / 16.f, 7 / 16.f, -7 / 16.f};

// Up to kLanes pixels of one tile, a lane each. `wanted`: the lanes in use.
struct EdgePixels {
  int count = 0;
  TilePixels places[kLanes];
  // The rays of the pixels, and the steps to the neighbours': x, y, z of each. Beyond `count` the last again.
  alignas(64) float middle[3][kLanes], across[3][kLanes], down[3][kLanes];

  TilePixels Places(int from, int to) const {
    TilePixels all;
    for (int i = from; i < std::min(to, kLanes); ++i)
      all.rows |= places[i].rows, all.columns |= places[i].columns;
    return all;
  }
  MF Wanted() const { return hn::FirstN(df, static_cast<std::size_t>(count)); }
  // Of each pixel the k-th ray.
  Rays At(int k) const {
    const auto load = [](const float(&of)[3][kLanes]) {
      return Vec3{hn::Load(df, of[0]), hn::Load(df, of[1]), hn::Load(df, of[2])};
    };
    const Vec3 du = load(across), dv = load(down);
    return {Along(Along(load(middle), F(kAcross[k]), du), F(kDown[k]), dv), du, dv};
  }
  // The rays of one or two pixels, one after the other: side by side, they go the same way.
  static constexpr int kTogether = std::max(1, kLanes / kSubpixels);
  Vec3 Of(int pixel, int first_ray) const {
    const MF one = hn::FirstN(df, kSubpixels);
    const int other = std::min(pixel + kTogether - 1, kLanes - 1);
    const auto spread = [&](const float(&of)[kLanes]) {
      return kTogether == 1 ? F(of[pixel]) : hn::IfThenElse(one, F(of[pixel]), F(of[other]));
    };
    const auto load = [&](const float(&of)[3][kLanes]) {
      return Vec3{spread(of[0]), spread(of[1]), spread(of[2])};
    };
    alignas(64) float a[kLanes], d[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      a[i] = kAcross[(first_ray + i) % kSubpixels];
      d[i] = kDown[(first_ray + i) % kSubpixels];
    }
    return Along(Along(load(middle), hn::Load(df, a), load(across)), hn::Load(df, d), load(down));
  }
};

HWY_INLINE Vec3 Either(MF where, const Vec3& a, const Vec3& b) {
  return {hn::IfThenElse(where, a.x, b.x), hn::IfThenElse(where, a.y, b.y), hn::IfThenElse(where, a.z, b.z)};
}

HWY_INLINE void Add(const Colours& c, VF weight, Colours& sum) {
  sum = {hn::MulAdd(c.r, weight, sum.r), hn::MulAdd(c.g, weight, sum.g), hn::MulAdd(c.b, weight, sum.b)};
}

// Pixels at edges are drawn by so many together, whatever a vector's width: that something transparent is
// before one of them, and in which order their sides are added up, are the same then.
constexpr int kGroup = 16;
constexpr int kPackets = kGroup / kLanes;
struct EdgeGroup {
  int packets = 0;  // in use; all but the last are full
  EdgePixels pixels[kPackets];
};

// Each ray with a colour of its own.
void MeanOfAll(const Slice& slice, const Seen& seen, const EdgePixels& pixels, Colours& sum) {
  sum = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  for (int k = 0; k < kSubpixels; ++k) {
    Rays rays = pixels.At(k);
    rays.du = Scale(rays.du, F(0.5f)), rays.dv = Scale(rays.dv, F(0.5f));
    TriangleHits triangles;
    Hit hit = Trace(slice, seen, pixels.Places(0, pixels.count), rays.d, triangles);
    EndPlane(slice, rays.d, hit);
    Add(Look(slice, seen, rays, hit, triangles, pixels.Wanted()).colour, F(1.0f / kSubpixels), sum);
  }
}

// What the rays of a packet of pixels meet.
struct EdgeHits {
  MF wanted;
  Hit hits[kSubpixels];
  TriangleHits triangles[kSubpixels];
  VI code[kSubpixels];  // the side of the thing; -1: it is done
};

// False: something transparent is before them.
bool MeetSides(const Slice& slice, const Seen& seen, const EdgePixels& pixels, EdgeHits& met) {
  alignas(64) float t_of[kSubpixels][kLanes] = {};
  alignas(64) std::int32_t thing_of[kSubpixels][kLanes] = {};
  for (int ray = 0; ray < pixels.count * kSubpixels; ray += kLanes) {
    TriangleHits own;
    const int pixel = ray / kSubpixels;
    const Vec3 d = pixels.Of(pixel, ray % kSubpixels);
    const Hit hit = Trace(slice, seen, pixels.Places(pixel, pixel + EdgePixels::kTogether), d, own);
    if (!hn::AllFalse(df, Veiled(slice, seen, d, hit.t))) return false;
    alignas(64) float t[kLanes];
    alignas(64) std::int32_t thing[kLanes];
    hn::Store(hit.t, df, t);
    hn::Store(hit.thing, di, thing);
    for (int i = 0; i < kLanes; ++i) {
      const int k = (ray + i) % kSubpixels, of = (ray + i) / kSubpixels;
      if (of >= kLanes) break;
      t_of[k][of] = t[i];
      thing_of[k][of] = thing[i];
      if (thing[i] < 0 || !slice.things->all[thing[i]].triangles) continue;
      met.triangles[k].face[of] = own.face[i];
      met.triangles[k].u[of] = own.u[i];
      met.triangles[k].v[of] = own.v[i];
    }
  }
  met.wanted = pixels.Wanted();
  for (int k = 0; k < kSubpixels; ++k) {
    const Vec3 d = pixels.At(k).d;
    met.hits[k] = {hn::Load(df, t_of[k]), hn::Load(di, thing_of[k])};
    alignas(64) std::int32_t index[kLanes];
    hn::Store(met.hits[k].thing, di, index);
    met.code[k] = hn::Zero(di);
    for (MF left = met.wanted; !hn::AllFalse(df, left);) {
      const int i = index[hn::FindFirstTrue(df, left)];
      const MF here = hn::And(left, hn::RebindMask(df, hn::Eq(met.hits[k].thing, hn::Set(di, i))));
      left = hn::AndNot(here, left);
      const VI side = i < 0 ? hn::Zero(di) : SideOf(slice, i, d, met.hits[k].t, met.triangles[k], here);
      met.code[k] = hn::IfThenElse(hn::RebindMask(di, here), CodeOf(side, i), met.code[k]);
    }
  }
  return true;
}

// Adds the colour of one side of a thing (index -1: the sky) to the pixels that it is met in by a ray from
// `first` on, by how many of them meet it.
void AddSide(const Slice& slice, const EdgePixels& pixels, int index, VI one, int first, EdgeHits& met,
             Colours& sum) {
  const bool triangular = index >= 0 && slice.things->all[index].triangles;
  VF t = F(1), weight = hn::Zero(df);
  Rays rays = pixels.At(first);
  rays.du = Scale(rays.du, F(0.5f)), rays.dv = Scale(rays.dv, F(0.5f));
  TriangleHits triangles = met.triangles[first];
  Vec3 middle{hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  MF here = hn::Lt(F(1), F(0));
  for (int k = first; k < kSubpixels; ++k) {
    const auto same = hn::Eq(met.code[k], one);
    const MF same_f = hn::RebindMask(df, same), fresh = hn::AndNot(here, same_f);
    met.code[k] = hn::IfThenElse(same, hn::Set(di, -1), met.code[k]);
    const VF share = hn::IfThenElseZero(same_f, F(1.0f / kSubpixels));
    weight = hn::Add(weight, share);
    const Vec3 d = pixels.At(k).d;
    middle = Along(middle, share, d);
    if (hn::AllFalse(df, fresh)) continue;
    here = hn::Or(here, fresh);
    t = hn::IfThenElse(fresh, met.hits[k].t, t);
    rays.d = Either(fresh, d, rays.d);
    if (k > first && triangular) Keep(fresh, met.triangles[k], triangles);
  }
  if (hn::AllFalse(df, here)) return;
  if (!triangular) {
    // In the middle of the rays that meet it, unless it bends away from there.
    middle = Scale(middle, hn::Div(F(1), hn::Max(weight, F(1.0f / kSubpixels))));
    VF t_middle = F(1);
    if (index >= 0) {
      const Geom& thing = slice.things->all[index];
      const GeomInstance& placed = slice.placement->things[index];
      t_middle = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, middle), F(kFar), triangles);
    }
    const MF meets = hn::Lt(t_middle, F(kFar));
    rays.d = Either(meets, middle, rays.d);
    t = hn::IfThenElse(meets, t_middle, t);
  }
  Surface surface;
  ShadeHit(slice, index, rays, t, triangles, here, surface);
  const Air& air = slice.things->air;
  const Colours colour = Finish(surface);
  Add(air.per_m > 0 && index >= 0 ? ThroughAir(air, ContrastAt(air, rays.d, t), colour) : colour, weight,
      sum);
}

// One colour for each side of each thing in a pixel, by how many of the rays meet it. False: something
// transparent is before them.
bool MeanBySides(const Slice& slice, const Seen& seen, const EdgeGroup& group, Colours* sums) {
  EdgeHits met[kPackets];
  for (int p = 0; p < group.packets; ++p) {
    if (!MeetSides(slice, seen, group.pixels[p], met[p])) return false;
    sums[p] = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  }
  for (int first = 0; first < kSubpixels; ++first) {
    for (int p = 0; p < group.packets;) {
      const MF left = hn::And(met[p].wanted, hn::RebindMask(df, hn::Ne(met[p].code[first], hn::Set(di, -1))));
      if (hn::AllFalse(df, left)) {
        ++p;
        continue;
      }
      alignas(64) std::int32_t codes[kLanes], index[kLanes];
      hn::Store(met[p].code[first], di, codes);
      hn::Store(met[p].hits[first].thing, di, index);
      const auto lane = hn::FindFirstTrue(df, left);
      for (int q = 0; q < group.packets; ++q)
        AddSide(slice, group.pixels[q], index[lane], hn::Set(di, codes[lane]), first, met[q], sums[q]);
    }
  }
  return true;
}

void SmoothRowsImpl(const Slice& slice, int begin, int end, const Canvas& canvas) {
  const Lens& lens = *slice.lens;
  const auto load = [&](const std::uint32_t* p) {
    return hn::LoadU(di, reinterpret_cast<const std::int32_t*>(p));
  };
  const VI outside = hn::Set(di, static_cast<std::int32_t>(kOutside));
  static thread_local Seen kept;
  Seen& seen = kept;
  for (int column = 0; column < lens.tiles_x; ++column) {
    const int left = column * Lens::kTile, right = left + Lens::kTile;
    struct Place {
      int u, v;
    };
    Place found[Lens::kTile * Lens::kTile];
    int edges = 0;
    for (int v = begin; v < end; ++v) {
      const std::uint32_t* row = canvas.code + static_cast<std::ptrdiff_t>(v) * lens.stride;
      const std::uint32_t* above = v > 0 ? row - lens.stride : row;
      const std::uint32_t* below = v + 1 < lens.height ? row + lens.stride : row;
      const std::uint32_t* common = canvas.common + static_cast<std::ptrdiff_t>(v) * lens.tiles_x + column;
      const std::uint32_t one = *common;
      if (one < kAlwaysSmooth && above[left] == one && below[left] == one &&
          (v == 0 || common[-lens.tiles_x] == one) && (v + 1 == lens.height || common[lens.tiles_x] == one) &&
          (left == 0 || row[left - 1] == one) && (right >= lens.width || row[right] == one)) {
        continue;
      }
      for (int u = left; u < std::min(right, lens.width); u += kLanes) {
        const VI coded = load(row + u);
        const VI own = hn::And(coded, outside);  // without the top bit
        const auto differs = [&](const std::uint32_t* other) {
          const VI o = hn::And(load(other), outside);
          return hn::And(hn::Ne(own, o), hn::Ne(o, outside));
        };
        // Left of the first pixel and right of the last there is no neighbour: compare the row with itself.
        auto edge = hn::Or(hn::Or(differs(above + u), differs(below + u)),
                           hn::Or(differs(row + (u > 0 ? u - 1 : u)), differs(row + u + 1)));
        if (u == 0) {
          alignas(64) std::uint32_t shifted[kLanes];
          shifted[0] = row[0];
          for (int i = 1; i < kLanes; ++i) shifted[i] = row[i - 1];
          edge = hn::Or(edge, differs(shifted));
        }
        edge = hn::Or(edge, hn::Lt(coded, hn::Zero(di)));
        edge = hn::And(edge, hn::Ne(own, outside));
        for (std::uint32_t bits = BitsOf(hn::RebindMask(df, edge)); bits != 0; bits &= bits - 1) {
          const int at = u + std::countr_zero(bits);
          if (at < lens.width) found[edges++] = {at, v};
        }
      }
    }
    if (edges == 0) continue;
    ListSeen(slice, column, seen);
    const bool simple = !slice.shadows && slice.things->haze.thing < 0;
    for (int from = 0; from < edges; from += kGroup) {
      EdgeGroup group;
      group.packets = (std::min(kGroup, edges - from) + kLanes - 1) / kLanes;
      const Aligned<float>* const table[3] = {&lens.x, &lens.y, &lens.z};
      for (int p = 0; p < group.packets; ++p) {
        const Place* const places = found + from + p * kLanes;
        EdgePixels& pixels = group.pixels[p];
        pixels.count = std::min(kLanes, edges - from - p * kLanes);
        for (int i = 0; i < kLanes; ++i) {
          const Place& place = places[std::min(i, pixels.count - 1)];
          const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(place.v) * lens.stride + place.u;
          pixels.places[i] = OnePixel(place.u, place.v);
          for (int c = 0; c < 3; ++c) {
            const float* const of = table[c]->get() + at;
            pixels.middle[c][i] = of[0];
            pixels.across[c][i] = of[1] - of[0];
            pixels.down[c][i] = of[lens.stride] - of[0];
          }
        }
      }
      Colours means[kPackets];
      if (!simple || !MeanBySides(slice, seen, group, means))
        for (int p = 0; p < group.packets; ++p) MeanOfAll(slice, seen, group.pixels[p], means[p]);
      for (int p = 0; p < group.packets; ++p) {
        if (canvas.grey) {
          alignas(64) float grey[kLanes];
          hn::Store(GreyOf(means[p]), df, grey);
          for (int i = 0; i < group.pixels[p].count; ++i) {
            const Place& place = found[from + p * kLanes + i];
            canvas.grey[place.v * canvas.step + place.u] = grey[i];
          }
          continue;
        }
        alignas(64) std::int32_t channel[3][kLanes];
        hn::Store(Rounded(means[p].b), di, channel[0]);
        hn::Store(Rounded(means[p].g), di, channel[1]);
        hn::Store(Rounded(means[p].r), di, channel[2]);
        for (int i = 0; i < group.pixels[p].count; ++i) {
          const Place& place = found[from + p * kLanes + i];
          std::uint8_t* const bgr =
              canvas.bgr + place.v * canvas.step + 3 * static_cast<std::size_t>(place.u);
          for (int j = 0; j < 3; ++j) bgr[j] = static_cast<std::uint8_t>(channel[j][i]);
        }
      }
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
