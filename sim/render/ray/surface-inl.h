// SPDX-License-Identifier: Apache-2.0
// The colour of a surface, of the sky, and of the haze before them: light by OpenGL's rules, for each pixel.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_SURFACE_INL_H_
#undef KESTREL_SIM_RAY_SURFACE_INL_H_
#else
#define KESTREL_SIM_RAY_SURFACE_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/shapes-inl.h"
#include "sim/render/ray/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

constexpr float kSkyDistance_m = 350;  // of the haze: as far as MuJoCo puts the sky of the OpenGL renderer

// Which rays from the points to the light (directions not normalised; t up to reach) meet something opaque.
MF InShadow(const Slice& slice, const Vec3& p_C, const Vec3& d_C, VF reach, MF wanted) {
  MF dark = hn::Lt(F(1), F(0));
  TriangleHits unused;
  for (std::size_t i = 0; i < slice.things->all.size(); ++i) {
    const GeomInstance& placed = slice.placement->things[i];
    if (placed.transparent) continue;
    const Geom& thing = slice.things->all[i];
    const Vec3 o = Rotate(placed.R, p_C) + Load3(placed.o), d = Rotate(placed.R, d_C);
    dark = hn::Or(dark, hn::Lt(Enter(thing, thing.size, o, d, reach, unused), reach));
    if (hn::AllTrue(df, hn::Or(dark, hn::Not(wanted)))) break;
  }
  return dark;
}

// Light on the points, 0 to 1 of the thing's colour, each channel; normals of length 1, in C. Shadows are
// marked in the side.
HWY_INLINE Colours Light(const Slice& slice, const Geom& thing, const Vec3& p, const Vec3& n, const Vec3& d,
                         MF wanted, VI& side) {
  const RenderScene& things = *slice.things;
  const VF none = things.lit ? hn::Zero(df) : F(0.3f);
  const auto start = [&](int k) { return hn::Mul(F(thing.rgba[k]), hn::Add(none, F(thing.emission))); };
  VF sum[3] = {start(0), start(1), start(2)};
  for (std::size_t i = 0; i < things.lights.size(); ++i) {
    const ray::Light& light = things.lights[i];
    const LightInstance& placed = slice.placement->lights[i];
    Vec3 towards = Scale(Load3(placed.direction), F(-1));
    VF strength = F(1), distance = F(kNone);
    if (!light.directional) {
      const Vec3 to_light = Load3(placed.position) - p;
      distance = LengthOf(to_light);
      const Vec3 axis = Load3(placed.direction);
      towards = Scale(to_light, hn::Div(F(1), hn::Max(distance, F(1e-9f))));
      strength =
          hn::Div(F(1), hn::MulAdd(hn::MulAdd(F(light.attenuation[2]), distance, F(light.attenuation[1])),
                                   distance, F(light.attenuation[0])));
      if (light.cutoff_cos > -1.5f) {
        const VF cosine = hn::Neg(Dot(towards, axis));
        VF spot = F(1);
        if (light.exponent > 0) {
          spot = hn::Exp(df, hn::Mul(F(light.exponent), hn::Log(df, hn::Max(cosine, F(1e-6f)))));
        }
        strength = hn::Mul(strength, hn::IfThenElseZero(hn::Ge(cosine, F(light.cutoff_cos)), spot));
      }
    }
    const VF cosine = Dot(n, towards);
    if (slice.shadows && light.shadows) {
      // From just above the surface, by what rounding may do at that distance.
      const VF lift = hn::MulAdd(LengthOf(p), F(1e-5f), F(1e-4f));
      const MF dark = InShadow(slice, Along(p, lift, n), towards, distance, wanted);
      strength = hn::IfThenElse(dark, hn::Zero(df), strength);
      // The outline of a shadow is an edge.
      const VI mark = hn::Set(di, static_cast<std::int32_t>(1 << (17 - 2 * std::min<std::size_t>(i, 3))));
      side = hn::Xor(side, hn::IfThenElseZero(hn::RebindMask(di, dark), mark));
    }
    const MF faces = hn::Gt(cosine, hn::Zero(df));
    VF shine = hn::Zero(df);
    if (thing.specular > 0 && light.specular.maxCoeff() > 0) {
      const Vec3 half = towards - Scale(d, hn::Div(F(1), LengthOf(d)));
      const VF c = hn::Div(Dot(n, half), hn::Max(LengthOf(half), F(1e-9f)));
      shine = hn::Exp(df, hn::Mul(F(128 * thing.shininess), hn::Log(df, hn::Max(c, F(1e-6f)))));
      shine = hn::IfThenElseZero(hn::And(faces, hn::Gt(c, hn::Zero(df))), hn::Mul(shine, F(thing.specular)));
    }
    const VF diffuse = hn::IfThenElseZero(faces, cosine);
    for (int k = 0; k < 3; ++k) {
      const VF of_colour =
          hn::Mul(F(thing.rgba[k]), hn::MulAdd(diffuse, F(light.diffuse[k]), F(light.ambient[k])));
      sum[k] = hn::MulAdd(strength, hn::MulAdd(shine, F(light.specular[k]), of_colour), sum[k]);
    }
  }
  const auto limited = [](VF v) { return hn::Min(hn::Max(v, hn::Zero(df)), F(1)); };
  return {limited(sum[0]), limited(sum[1]), limited(sum[2])};
}

// A surface lit, 0 to 255, and the texels that colour it.
struct Surface {
  Colours lit;
  VI side;  // which of the thing's sides, for telling edges
  Fetch fetch;
};

// Normal in G at the point p_G, and the side.
HWY_INLINE void NormalOf(const Geom& thing, const Vec3& p, const TriangleHits& hits, MF wanted, Vec3& n,
                         VI& side) {
  const VF zero = hn::Zero(df), one = F(1);
  side = hn::Zero(di);
  n = {zero, zero, one};
  const auto number = [](VF v) { return hn::ConvertTo(di, v); };
  switch (thing.type) {
    case mjGEOM_PLANE:
      side = hn::Set(di, 4);
      return;
    case mjGEOM_BOX: {
      const VF x = hn::Mul(p.x, F(1 / thing.size.x())), y = hn::Mul(p.y, F(1 / thing.size.y())),
               z = hn::Mul(p.z, F(1 / thing.size.z()));
      const VF ax = hn::Abs(x), ay = hn::Abs(y), az = hn::Abs(z);
      const MF on_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
      const MF on_y = hn::AndNot(on_x, hn::Ge(ay, az));
      const VF major = hn::IfThenElse(on_x, x, hn::IfThenElse(on_y, y, z));
      const VF sign = hn::CopySign(one, major);
      n = {hn::IfThenElseZero(on_x, sign), hn::IfThenElseZero(on_y, sign),
           hn::IfThenZeroElse(hn::Or(on_x, on_y), sign)};
      side = number(hn::Add(hn::IfThenElse(on_x, zero, hn::IfThenElse(on_y, F(2), F(4))),
                            hn::IfThenElse(hn::Lt(major, zero), one, zero)));
      return;
    }
    case mjGEOM_SPHERE:
    case mjGEOM_ELLIPSOID: {
      const Eigen::Vector3f by = thing.size.cwiseProduct(thing.size).cwiseInverse();
      n = {hn::Mul(p.x, F(by.x())), hn::Mul(p.y, F(by.y())), hn::Mul(p.z, F(by.z()))};
      break;
    }
    case mjGEOM_CYLINDER: {
      const VF round = hn::MulAdd(p.x, p.x, hn::Mul(p.y, p.y));
      const float rr = thing.size.x() * thing.size.x(), hh = thing.size.z() * thing.size.z();
      const MF on_cap = hn::Gt(hn::Mul(hn::Mul(p.z, p.z), F(rr)), hn::Mul(round, F(hh)));
      n = {hn::IfThenZeroElse(on_cap, p.x), hn::IfThenZeroElse(on_cap, p.y), hn::IfThenElseZero(on_cap, p.z)};
      side = number(hn::IfThenElse(on_cap, hn::IfThenElse(hn::Lt(p.z, zero), F(2), one), zero));
      break;
    }
    case mjGEOM_CAPSULE: {
      const VF h = F(thing.size.z());
      n = {p.x, p.y, hn::Sub(p.z, hn::Min(hn::Max(p.z, hn::Neg(h)), h))};
      break;
    }
    default: {
      alignas(64) float x[kLanes] = {}, y[kLanes] = {}, z[kLanes] = {};
      const auto& common = thing.triangles->one_normal;
      const std::uint32_t bits = common ? 0 : BitsOf(wanted);
      for (int i = 0; i < kLanes; ++i) {
        if (!(bits >> i & 1)) continue;
        const Triangles::Corner* corner =
            &thing.triangles->corners[3 * static_cast<std::size_t>(hits.face[i])];
        const Eigen::Vector3f normal = (1 - hits.u[i] - hits.v[i]) * corner[0].normal +
                                       hits.u[i] * corner[1].normal + hits.v[i] * corner[2].normal;
        x[i] = normal.x(), y[i] = normal.y(), z[i] = normal.z();
      }
      n = common ? Load3(common->data()) : Vec3{hn::Load(df, x), hn::Load(df, y), hn::Load(df, z)};
      n = Scale(n, hn::Div(one, hn::Max(LengthOf(n), F(1e-30f))));
      // A crease shows by a turn of the normal.
      const auto part = [&](VF v) { return hn::NearestInt(hn::MulAdd(v, F(3), F(3))); };
      side = hn::Or(part(n.x), hn::Or(hn::ShiftLeft<3>(part(n.y)), hn::ShiftLeft<6>(part(n.z))));
      return;
    }
  }
  n = Scale(n, hn::Div(one, hn::Max(LengthOf(n), F(1e-30f))));
}

// A mesh in front of itself shows by a leap of its tangent plane's distance from the viewpoint, which on
// level ground is the same near and far; one of plain facets, whose normals say nothing, by a leap of its own distance.
// In bits of the side that the normal leaves free; from: the viewpoint, to the point.
HWY_INLINE VI LeapOf(const Triangles& triangles, const Vec3& n, const Vec3& from) {
  VF away = LengthOf(from);
  if (!triangles.plain_facets) away = hn::Max(hn::Abs(Dot(n, from)), hn::Mul(F(1e-2f), away));
  const VI octave = hn::ConvertTo(di, hn::Floor(Log2(hn::Max(away, F(1e-9f)))));
  return hn::ShiftLeft<9>(hn::And(octave, hn::Set(di, 255)));
}

// How the point on a surface moves from a pixel to its neighbour, whose ray differs by e.
class Steps {
 public:
  HWY_INLINE Steps(const Geom& thing, const Vec3& d, const Vec3& n, VF t) : d_(d), n_(n), t_(t) {
    is_plane_ = thing.type == mjGEOM_PLANE;
    const VF n_d = is_plane_ ? d.z : Dot(n, d);
    // Near the outline the surface is seen edge on, and the linear step would be endless; on a mesh it would
    // leave the part that is seen long before.
    const VF least = thing.triangles ? hn::Mul(F(0.03f), LengthOf(d)) : F(1e-4f);
    const VF steep = hn::IfThenElse(hn::Lt(hn::Abs(n_d), least), hn::CopySign(least, n_d), n_d);
    inverse_ = hn::Div(F(-1), steep);
  }
  HWY_INLINE Vec3 To(const Vec3& e) const {
    const VF along = hn::Mul(is_plane_ ? e.z : Dot(n_, e), inverse_);
    return Scale(Along(e, along, d_), t_);
  }

 private:
  const Vec3 &d_, &n_;
  VF t_, inverse_;
  bool is_plane_;
};

HWY_INLINE void Shade(const Slice& slice, int index, const Rays& rays, VF t, const TriangleHits& hits,
                      MF wanted, Surface& surface) {
  const Geom& thing = slice.things->all[index];
  const GeomInstance& placed = slice.placement->things[index];
  const bool flat = placed.flat && !(slice.shadows && slice.things->lit);
  const auto constant = [&](int side) {
    const float* c = placed.face[side];
    return Colours{F(c[0]), F(c[1]), F(c[2])};
  };
  t = hn::IfThenElse(wanted, t, F(1));
  surface.fetch.picture = nullptr;
  if (flat && thing.type == mjGEOM_PLANE && !thing.texture) {
    surface.lit = constant(4);
    surface.side = hn::Set(di, 4);
    return;
  }
  const Vec3 d = Rotate(placed.R, rays.d);
  const Vec3 p = Along(Load3(placed.o), t, d);
  Vec3 n;
  NormalOf(thing, p, hits, wanted, n, surface.side);
  if (thing.triangles) surface.side = hn::Or(surface.side, LeapOf(*thing.triangles, n, Scale(d, t)));
  Colours& colour = surface.lit;
  if (flat && thing.type == mjGEOM_PLANE) {
    colour = constant(4);
  } else if (flat) {
    // Of the two sides along an axis only the one towards the viewpoint is seen.
    const auto seen = [&](int axis) { return constant(2 * axis + (placed.o[axis] < 0 ? 1 : 0)); };
    const Colours x = seen(0), y = seen(1), z = seen(2);
    const MF on_x = hn::RebindMask(df, hn::Lt(surface.side, hn::Set(di, 2)));
    const MF on_xy = hn::RebindMask(df, hn::Lt(surface.side, hn::Set(di, 4)));
    const auto pick = [&](VF a, VF b, VF c) { return hn::IfThenElse(on_x, a, hn::IfThenElse(on_xy, b, c)); };
    colour = {pick(x.r, y.r, z.r), pick(x.g, y.g, z.g), pick(x.b, y.b, z.b)};
  } else if (thing.bright) {
    colour = {F(255), F(255), F(255)};
  } else {
    colour = Light(slice, thing, Scale(rays.d, t), RotateBack(placed.R, n), rays.d, wanted, surface.side);
    const VF whole = F(255);
    colour = {hn::Mul(colour.r, whole), hn::Mul(colour.g, whole), hn::Mul(colour.b, whole)};
  }
  if (!thing.texture) return;
  if (thing.mapping == Mapping::kExplicit && thing.triangles->plain_facets) {
    alignas(64) float s[kLanes] = {}, tt[kLanes] = {};
    for (std::uint32_t bits = BitsOf(wanted); bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const auto& st = thing.triangles->corners[3 * static_cast<std::size_t>(hits.face[i])].st;
      s[i] = st.x(), tt[i] = st.y();
    }
    const VF none = hn::Zero(df);
    return PlanRepeating(*thing.texture, hn::Load(df, s), hn::Load(df, tt), none, none, none, none, wanted,
                         surface.fetch);
  }

  const Steps steps(thing, d, n, t);
  const Vec3 p_u = steps.To(Rotate(placed.R, rays.du)), p_v = steps.To(Rotate(placed.R, rays.dv));
  switch (thing.mapping) {
    case Mapping::kPlanar: {
      const VF a = F(thing.scale_s), b = F(thing.scale_t), half = F(0.5f);
      PlanRepeating(*thing.texture, hn::MulSub(p.x, a, half), hn::MulSub(p.y, b, half), hn::Mul(p_u.x, a),
                    hn::Mul(p_u.y, b), hn::Mul(p_v.x, a), hn::Mul(p_v.y, b), wanted, surface.fetch);
      break;
    }
    case Mapping::kExplicit: {
      alignas(64) float s[kLanes] = {}, tt[kLanes] = {}, gradient[6][kLanes] = {};
      const std::uint32_t bits = BitsOf(wanted);
      for (int i = 0; i < kLanes; ++i) {
        if (!(bits >> i & 1)) continue;
        const Triangles::Corner* corner =
            &thing.triangles->corners[3 * static_cast<std::size_t>(hits.face[i])];
        const Eigen::Vector2f st =
            (1 - hits.u[i] - hits.v[i]) * corner[0].st + hits.u[i] * corner[1].st + hits.v[i] * corner[2].st;
        s[i] = st.x(), tt[i] = st.y();
        const auto& g = thing.triangles->st_gradient[hits.face[i]];
        for (int k = 0; k < 6; ++k) gradient[k][i] = g(k / 3, k % 3);
      }
      const Vec3 grad_s{hn::Load(df, gradient[0]), hn::Load(df, gradient[1]), hn::Load(df, gradient[2])};
      const Vec3 grad_t{hn::Load(df, gradient[3]), hn::Load(df, gradient[4]), hn::Load(df, gradient[5])};
      PlanRepeating(*thing.texture, hn::Load(df, s), hn::Load(df, tt), Dot(grad_s, p_u), Dot(grad_t, p_u),
                    Dot(grad_s, p_v), Dot(grad_t, p_v), wanted, surface.fetch);
      break;
    }
    default: {
      Vec3 q = p, q_u = p_u, q_v = p_v;
      const Vec3 scale{F(thing.cube_scale.x()), F(thing.cube_scale.y()), F(thing.cube_scale.z())};
      const auto scaled = [&](const Vec3& v) {
        return Vec3{hn::Mul(v.x, scale.x), hn::Mul(v.y, scale.y), hn::Mul(v.z, scale.z)};
      };
      if (thing.type == mjGEOM_CAPSULE) {  // MuJoCo draws the caps by a sphere of their own scale
        const VF h = F(thing.size.z()), stretch = F(thing.size.z() / thing.size.x());
        const MF cap = hn::Gt(hn::Abs(p.z), h);
        const VF end = hn::CopySign(h, p.z);
        q.z = hn::IfThenElse(cap, hn::MulAdd(hn::Sub(p.z, end), stretch, end), p.z);
        q_u.z = hn::IfThenElse(cap, hn::Mul(p_u.z, stretch), p_u.z);
        q_v.z = hn::IfThenElse(cap, hn::Mul(p_v.z, stretch), p_v.z);
      }
      PlanCube(*thing.texture, scaled(q), scaled(q_u), scaled(q_v), wanted, surface.fetch);
      break;
    }
  }
}

HWY_INLINE void ShadeSky(const Slice& slice, const Rays& rays, MF wanted, Surface& surface) {
  surface.side = hn::Zero(di);
  surface.fetch.picture = nullptr;
  const VF light = slice.things->sky ? F(255) : hn::Zero(df);
  surface.lit = {light, light, light};
  if (!slice.things->sky) return;
  const auto turned = [&](const Vec3& v) {
    const Vec3 m = Rotate(slice.placement->R_MC, v);
    return Vec3{m.x, m.z, hn::Neg(m.y)};
  };
  PlanCube(*slice.things->sky, turned(rays.d), turned(rays.du), turned(rays.dv), wanted, surface.fetch);
}

HWY_INLINE Colours Tinted(const Colours& lit, const std::int32_t* mixed) {
  const Colours texel = Unpack(mixed);
  const VF part = F(1.0f / 255);
  return {hn::Mul(lit.r, hn::Mul(texel.r, part)), hn::Mul(lit.g, hn::Mul(texel.g, part)),
          hn::Mul(lit.b, hn::Mul(texel.b, part))};
}

HWY_INLINE Colours Finish(const Surface& surface) {
  if (!surface.fetch.picture) return surface.lit;
  alignas(64) std::int32_t mixed[4 * kLanes];
  Mix(surface.fetch, mixed);
  return Tinted(surface.lit, mixed);
}

HWY_INLINE Colours Over(const Colours& above, VF alpha, const Colours& below, MF where) {
  const VF a = hn::IfThenElseZero(where, alpha);
  const auto mix = [&](VF x, VF y) { return hn::MulAdd(a, hn::Sub(x, y), y); };
  return {mix(above.r, below.r), mix(above.g, below.g), mix(above.b, below.b)};
}

// Of contrast with the air, what is left at t along the rays.
HWY_INLINE VF ContrastAt(const Air& air, const Vec3& d, VF t) {
  // exp(-x) by the eighth power of exp(-x / 8).
  const VF x = hn::Mul(hn::Mul(hn::Min(t, F(kFar)), LengthOf(d)), F(air.per_m / 8));
  VF share = hn::Div(F(1), hn::MulAdd(x, hn::MulAdd(x, hn::MulAdd(x, F(1.0f / 6), F(0.5f)), F(1)), F(1)));
  for (int i = 0; i < 3; ++i) share = hn::Mul(share, share);
  return share;
}
HWY_INLINE Colours ThroughAir(const Air& air, VF contrast, const Colours& c) {
  const auto mix = [&](VF own, float rgb) { return hn::MulAdd(contrast, hn::Sub(own, F(rgb)), F(rgb)); };
  return {mix(c.r, air.rgb.x()), mix(c.g, air.rgb.y()), mix(c.b, air.rgb.z())};
}

// Where the haze is, a ray below the horizon: 0 at the horizon, 1 where it stands on the plane; and how far
// away.
HWY_INLINE void HazeAt(const GeomInstance& plane, float width, const Vec3& d, VF& u, VF& down, VF& distance) {
  const VF up = Rotate(plane.R, d).z;
  const VF level = hn::Sqrt(hn::Max(hn::NegMulAdd(up, up, Dot(d, d)), F(1e-20f)));
  u = hn::Div(hn::Mul(hn::Neg(up), F(kSkyDistance_m / plane.o[2])), level);
  down = hn::Div(u, hn::MulAdd(u, F(width), F(1)));
  distance = hn::Div(hn::Mul(hn::NegMulAdd(down, F(width), F(1)), F(kSkyDistance_m)), level);
}

// Behind the haze an endless plane gives way to the sky, into which the haze fades: to the upright cylinder
// that MuJoCo shows it on.
HWY_INLINE void EndPlane(const Slice& slice, const Vec3& d, Hit& hit) {
  const Haze& haze = slice.things->haze;
  if (haze.thing < 0 || !(slice.placement->things[haze.thing].o[2] > 0)) return;
  const Vec3 d_M = Rotate(slice.placement->R_MC, d);
  const VF level = hn::Sqrt(hn::MulAdd(d_M.x, d_M.x, hn::Mul(d_M.y, d_M.y)));
  const MF beyond = hn::And(hn::Gt(hn::Mul(hit.t, hn::Max(level, hn::Abs(d_M.z))), F(kSkyDistance_m)),
                            hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, haze.thing))));
  hit.thing = hn::IfThenElse(hn::RebindMask(di, beyond), hn::Set(di, -1), hit.thing);
  hit.t = hn::IfThenElse(beyond, F(kNone), hit.t);
}

// A truncated cone round the viewpoint, from the height of the plane up to the horizon, faded at both ends.
HWY_MAYBE_UNUSED Colours Hazed(const Slice& slice, const Rays& rays, VF t, const Colours& below) {
  const Haze& haze = slice.things->haze;
  const GeomInstance& plane = slice.placement->things[haze.thing];
  const float width = haze.width;
  if (!(plane.o[2] > 0)) return below;
  VF u, down, distance;
  HazeAt(plane, width, rays.d, u, down, distance);
  const float turn = width / (1 + width);
  const VF h = hn::Sub(F(1), down);
  const VF alpha =
      hn::Min(hn::Div(h, F(std::max(turn, 1e-6f))), hn::Mul(down, F(1 / std::max(1 - turn, 1e-6f))));
  const MF where = hn::And(hn::And(hn::Gt(u, hn::Zero(df)), hn::Le(down, F(1))), hn::Lt(distance, t));
  const Colours colour{F(255 * haze.rgb.x()), F(255 * haze.rgb.y()), F(255 * haze.rgb.z())};
  return Over(colour, alpha, below, where);
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
