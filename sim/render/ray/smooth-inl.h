// SPDX-License-Identifier: Apache-2.0
// Pixels at edges, drawn again by eight rays each.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_SMOOTH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_SMOOTH_INL_H_
#undef KESTREL_SIM_RAY_SMOOTH_INL_H_
#else
#define KESTREL_SIM_RAY_SMOOTH_INL_H_
#endif

#include <algorithm>
#include <bit>

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/look-inl.h"
#include "sim/render/ray/surface-inl.h"
#include "sim/render/ray/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

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
  Rays Middles() const {
    const auto load = [](const float(&of)[3][kLanes]) {
      return Vec3{hn::Load(df, of[0]), hn::Load(df, of[1]), hn::Load(df, of[2])};
    };
    return {load(middle), load(across), load(down)};
  }
  // Of each pixel the k-th ray.
  Rays At(int k) const {
    const Rays of = Middles();
    return {Along(Along(of.d, F(kAcross[k]), of.du), F(kDown[k]), of.dv), of.du, of.dv};
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

void MeetSides(const Slice& slice, const Seen& seen, const EdgePixels& pixels, EdgeHits& met) {
  alignas(64) float t_of[kSubpixels][kLanes] = {};
  alignas(64) std::int32_t thing_of[kSubpixels][kLanes] = {};
  for (int ray = 0; ray < pixels.count * kSubpixels; ray += kLanes) {
    TriangleHits own;
    const int pixel = ray / kSubpixels;
    const Vec3 d = pixels.Of(pixel, ray % kSubpixels);
    const Hit hit = Trace(slice, seen, pixels.Places(pixel, pixel + EdgePixels::kTogether), d, own);
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
}

// Whether of each pixel what is transparent is before all rays or before none, so that it need not be looked at for
// each ray.
bool VeiledAlike(const Slice& slice, const Seen& seen, const EdgePixels& pixels, const EdgeHits& met) {
  TriangleHits unused;
  for (const int i : seen.transparent) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    MF all = met.wanted, any = hn::Lt(F(1), F(0));
    for (int k = 0; k < kSubpixels; ++k) {
      const VF most = met.hits[k].t;
      const MF here = hn::Lt(
          Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, pixels.At(k).d), most, unused), most);
      all = hn::And(all, here);
      any = hn::Or(any, here);
    }
    if (!hn::AllFalse(df, hn::AndNot(all, hn::And(any, met.wanted)))) return false;
  }
  return true;
}

// The rays through the pixels' middles see it.
void AddVeil(const Slice& slice, const Seen& seen, const EdgePixels& pixels, const EdgeHits& met,
             Colours& c) {
  if (seen.transparent.empty()) return;
  VF most = met.hits[0].t;
  for (int k = 1; k < kSubpixels; ++k) most = hn::Max(most, met.hits[k].t);
  c = Through(VeilOf(slice, seen, pixels.Middles(), most, met.wanted), c);
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

// One colour for each side of each thing in a pixel, by how many of the rays meet it. False: something transparent is
// before some of a pixel's rays and not before others.
bool MeanBySides(const Slice& slice, const Seen& seen, const EdgeGroup& group, Colours* sums) {
  EdgeHits met[kPackets];
  for (int p = 0; p < group.packets; ++p) {
    MeetSides(slice, seen, group.pixels[p], met[p]);
    if (!VeiledAlike(slice, seen, group.pixels[p], met[p])) return false;
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
  for (int p = 0; p < group.packets; ++p) AddVeil(slice, seen, group.pixels[p], met[p], sums[p]);
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

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
