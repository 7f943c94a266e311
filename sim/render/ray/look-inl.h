// SPDX-License-Identifier: Apache-2.0
// The colours that the rays of a packet see: of what is opaque, through the haze, and of what is transparent before it.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_LOOK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_LOOK_INL_H_
#undef KESTREL_SIM_RAY_LOOK_INL_H_
#else
#define KESTREL_SIM_RAY_LOOK_INL_H_
#endif

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/surface-inl.h"
#include "sim/render/ray/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

constexpr std::uint32_t kOutside = 0x7fffffff;  // codes of a pixel
constexpr std::uint32_t kAlwaysSmooth = 0x80000000;

// Of a colour, which is in 0 to 255 by its making.
HWY_INLINE VI Rounded(VF colour) { return hn::NearestInt(colour); }

// The weights of ITU-R BT.601, as OpenCV's conversion to grey has them.
HWY_INLINE VF GreyOf(const Colours& c) {
  return hn::MulAdd(c.r, F(0.299f), hn::MulAdd(c.g, F(0.587f), hn::Mul(c.b, F(0.114f))));
}

// What is transparent before a packet: of what is behind it, `share` is seen, and `add` comes to it.
struct Veil {
  VF share;
  Colours add;
  MF any;   // the rays that meet something of it
  VI mark;  // added to the code
};

// Of what is nearer than `most`.
HWY_INLINE Veil VeilOf(const Slice& slice, const Seen& seen, const Rays& rays, VF most, MF wanted) {
  const VF none = hn::Zero(df), all = F(1);
  // As MuJoCo draws them: all from front to back, then all from back to front.
  Veil first{all, {none, none, none}, hn::Lt(all, none), hn::Zero(di)}, then = first;
  for (const int i : seen.transparent) {
    const Geom& thing = slice.things->all[i];
    const GeomInstance& placed = slice.placement->things[i];
    TriangleHits own;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, rays.d), most, own);
    const MF here = hn::And(wanted, hn::Lt(t, most));
    if (hn::AllFalse(df, here)) continue;
    Surface surface;
    Shade(slice, i, rays, t, own, here, surface);
    const Colours c = Finish(surface);
    const VF alpha = hn::IfThenElseZero(here, F(placed.alpha)), rest = hn::Sub(all, alpha);
    const VF inner = hn::Mul(then.share, alpha);
    const auto under = [&](VF add, VF own_colour) { return hn::MulAdd(inner, own_colour, add); };
    then.add = {under(then.add.r, c.r), under(then.add.g, c.g), under(then.add.b, c.b)};
    then.share = hn::Mul(then.share, rest);
    const auto over = [&](VF add, VF own_colour) { return hn::MulAdd(alpha, hn::Sub(own_colour, add), add); };
    first.add = {over(first.add.r, c.r), over(first.add.g, c.g), over(first.add.b, c.b)};
    first.share = hn::Mul(first.share, rest);
    first.any = hn::Or(first.any, here);
    const VI mark = hn::Set(di, static_cast<std::int32_t>(2 * ((i + 1) * 0x9e3779b1u & 0x0fffffff)));
    first.mark = hn::Add(first.mark, hn::IfThenElseZero(hn::RebindMask(di, here), mark));
  }
  const auto both = [&](VF inner, VF outer) { return hn::MulAdd(then.share, inner, outer); };
  return {hn::Mul(then.share, first.share),
          {both(first.add.r, then.add.r), both(first.add.g, then.add.g), both(first.add.b, then.add.b)},
          first.any,
          first.mark};
}

HWY_INLINE Colours Through(const Veil& veil, const Colours& c) {
  return {hn::MulAdd(veil.share, c.r, veil.add.r), hn::MulAdd(veil.share, c.g, veil.add.g),
          hn::MulAdd(veil.share, c.b, veil.add.b)};
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
  return thing.triangles ? hn::Or(side, LeapOf(*thing.triangles, normal, Scale(d, far))) : side;
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

  if (!seen.transparent.empty()) {
    const Veil veil = VeilOf(slice, seen, rays, hit.t, wanted);
    picture.colour = Through(veil, picture.colour);
    picture.code = hn::Add(picture.code, veil.mark);
  }
  picture.code = hn::And(picture.code, hn::Set(di, 0x3fffffff));
  return picture;
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
