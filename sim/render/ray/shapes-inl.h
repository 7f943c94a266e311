// SPDX-License-Identifier: Apache-2.0
// Where rays enter shapes. Rays that start inside see nothing of one: MuJoCo does not draw backs.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_SHAPES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_SHAPES_INL_H_
#undef KESTREL_SIM_RAY_SHAPES_INL_H_
#else
#define KESTREL_SIM_RAY_SHAPES_INL_H_
#endif

#include <algorithm>

#ifndef KESTREL_WITHOUT_EMBREE
#include "sim/render/ray/mesh/embree.h"
#endif
#include "sim/render/ray/packet-inl.h"
#include "sim/render/ray/render_scene.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

// What of a triangle a ray met; valid in the lanes where a thing of triangles was met last.
struct TriangleHits {
  alignas(64) std::uint32_t face[kLanes];
  alignas(64) float u[kLanes], v[kLanes];
};

struct Hit {
  VF t;
  VI thing;  // -1: none
};

HWY_INLINE VF Entry(MF hit, VF t) {
  hit = hn::And(hit, hn::And(hn::Gt(t, hn::Zero(df)), hn::Lt(t, F(kFar))));
  return hn::IfThenElse(hit, t, F(kNone));
}

HWY_INLINE VF EnterPlane(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  const VF t = hn::Div(hn::Neg(o.z), d.z);
  MF hit = hn::Eq(t, t);
  if (size.x() > 0) hit = hn::And(hit, hn::Le(hn::Abs(hn::MulAdd(t, d.x, o.x)), F(size.x())));
  if (size.y() > 0) hit = hn::And(hit, hn::Le(hn::Abs(hn::MulAdd(t, d.y, o.y)), F(size.y())));
  return Entry(hit, t);
}

HWY_INLINE VF EnterBox(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  const auto slab = [](float half, VF from, VF along, VF& in, VF& out) {
    const VF inverse = hn::Div(F(1), along);
    const VF towards = hn::CopySign(F(half), along);
    in = hn::Mul(hn::Neg(hn::Add(towards, from)), inverse);
    out = hn::Mul(hn::Sub(towards, from), inverse);
  };
  VF in_x, out_x, in_y, out_y, in_z, out_z;
  slab(size.x(), o.x, d.x, in_x, out_x);
  slab(size.y(), o.y, d.y, in_y, out_y);
  slab(size.z(), o.z, d.z, in_z, out_z);
  const VF in = hn::Max(in_x, hn::Max(in_y, in_z));
  const VF out = hn::Min(out_x, hn::Min(out_y, out_z));
  return Entry(hn::Le(in, out), in);
}

// By the foot of the perpendicular from the centre: the usual discriminant loses small spheres far away.
HWY_INLINE VF EnterSphere(VF radius2, const Vec3& o, const Vec3& d) {
  const VF a = Dot(d, d), b = Dot(o, d);
  const VF inverse = hn::Div(F(1), a);
  const Vec3 foot = Along(o, hn::Neg(hn::Mul(b, inverse)), d);
  const VF rest = hn::Sub(radius2, Dot(foot, foot));
  const VF t = hn::Mul(hn::Neg(hn::Add(b, hn::Sqrt(hn::Mul(a, hn::Max(rest, hn::Zero(df)))))), inverse);
  return Entry(hn::Ge(rest, hn::Zero(df)), t);
}

HWY_INLINE VF EnterEllipsoid(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  const Vec3 by{F(1 / size.x()), F(1 / size.y()), F(1 / size.z())};
  const Vec3 oo{hn::Mul(o.x, by.x), hn::Mul(o.y, by.y), hn::Mul(o.z, by.z)};
  const Vec3 dd{hn::Mul(d.x, by.x), hn::Mul(d.y, by.y), hn::Mul(d.z, by.z)};
  return EnterSphere(F(1), oo, dd);
}

HWY_INLINE VF EnterBarrel(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  const VF a = hn::MulAdd(d.x, d.x, hn::Mul(d.y, d.y));
  const VF b = hn::MulAdd(o.x, d.x, hn::Mul(o.y, d.y));
  const VF inverse = hn::Div(F(1), a);
  const VF back = hn::Neg(hn::Mul(b, inverse));
  const VF x = hn::MulAdd(back, d.x, o.x), y = hn::MulAdd(back, d.y, o.y);
  const VF rest = hn::Sub(F(size.x() * size.x()), hn::MulAdd(x, x, hn::Mul(y, y)));
  const VF t = hn::Mul(hn::Neg(hn::Add(b, hn::Sqrt(hn::Mul(a, hn::Max(rest, hn::Zero(df)))))), inverse);
  const VF z = hn::MulAdd(t, d.z, o.z);
  return Entry(hn::And(hn::Ge(rest, hn::Zero(df)), hn::Le(hn::Abs(z), F(size.z()))), t);
}

HWY_INLINE VF EnterCylinder(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  const VF t = hn::Div(hn::Sub(hn::CopySign(F(size.z()), o.z), o.z), d.z);
  const VF x = hn::MulAdd(t, d.x, o.x), y = hn::MulAdd(t, d.y, o.y);
  const MF on_cap = hn::And(hn::Gt(hn::Abs(o.z), F(size.z())),
                            hn::Le(hn::MulAdd(x, x, hn::Mul(y, y)), F(size.x() * size.x())));
  return hn::Min(Entry(on_cap, t), EnterBarrel(size, o, d));
}

HWY_INLINE VF EnterCapsule(const Eigen::Vector3f& size, const Vec3& o, const Vec3& d) {
  VF nearest = EnterBarrel(size, o, d);
  for (const float end : {size.z(), -size.z()}) {
    const Vec3 from{o.x, o.y, hn::Sub(o.z, F(end))};
    const VF t = EnterSphere(F(size.x() * size.x()), from, d);
    const VF beyond = hn::Mul(hn::MulAdd(t, d.z, from.z), F(end < 0 ? -1.0f : 1.0f));
    nearest = hn::Min(nearest, hn::IfThenElse(hn::Ge(beyond, hn::Zero(df)), t, F(kNone)));
  }
  return nearest;
}

#ifdef KESTREL_WITHOUT_EMBREE
VF EnterTriangles(const Triangles&, const Vec3&, const Vec3&, VF, TriangleHits&) { return F(kNone); }
#else
// Embree's packet as wide as ours. In a wider one Embree looks at the rays that are not there, too, where it
// has no instructions of that width.
template <int lanes>
struct Embree;
template <>
struct Embree<16> {
  using Packet = RTCRayHit16;
  static constexpr auto kIntersect = rtcIntersect16;
};
template <>
struct Embree<8> {
  using Packet = RTCRayHit8;
  static constexpr auto kIntersect = rtcIntersect8;
};
template <>
struct Embree<4> {
  using Packet = RTCRayHit4;
  static constexpr auto kIntersect = rtcIntersect4;
};

// Nearer than most. Rays side by side go the same way through the tree of triangles.
VF EnterTriangles(const Triangles& triangles, const Vec3& o, const Vec3& d, VF most, TriangleHits& hits) {
  Embree<kLanes>::Packet packet;
  alignas(64) int valid[kLanes];
  const auto put = [](VF v, float* to) { hn::StoreU(v, df, to); };
  std::fill(valid, valid + kLanes, -1);
  put(o.x, packet.ray.org_x), put(o.y, packet.ray.org_y), put(o.z, packet.ray.org_z);
  put(d.x, packet.ray.dir_x), put(d.y, packet.ray.dir_y), put(d.z, packet.ray.dir_z);
  put(F(0), packet.ray.tnear), put(hn::Min(most, F(kFar)), packet.ray.tfar), put(F(0), packet.ray.time);
  for (int i = 0; i < kLanes; ++i) {
    packet.ray.mask[i] = ~0u;
    packet.ray.flags[i] = packet.ray.id[i] = 0;
    packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  IntersectCoherent(Embree<kLanes>::kIntersect, valid, triangles.tree().scene(), &packet);
  alignas(64) float t[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    const bool met = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    t[i] = met ? packet.ray.tfar[i] : kNone;
    hits.face[i] = met ? packet.hit.primID[i] : 0;
    hits.u[i] = packet.hit.u[i];
    hits.v[i] = packet.hit.v[i];
  }
  return hn::Load(df, t);
}
#endif

// most: of triangles, none that is farther need be found.
HWY_INLINE VF Enter(const Geom& thing, const Eigen::Vector3f& size, const Vec3& o, const Vec3& d, VF most,
                    TriangleHits& hits) {
  switch (thing.type) {
    case mjGEOM_PLANE:
      return EnterPlane(size, o, d);
    case mjGEOM_BOX:
      return EnterBox(size, o, d);
    case mjGEOM_SPHERE:
    case mjGEOM_ELLIPSOID:
      return EnterEllipsoid(size, o, d);
    case mjGEOM_CYLINDER:
      return EnterCylinder(size, o, d);
    case mjGEOM_CAPSULE:
      return EnterCapsule(size, o, d);
    default:
      return EnterTriangles(*thing.triangles, o, d, most, hits);
  }
}

// A ray of the tile is o + t d with every |d_k - a_k| <= reach: a box may be met if for some t >= 0 the point
// o + t a is within half + t reach of it. Each of the six faces bounds t from one side. axis: in the frame of
// the thing.
HWY_INLINE MF MayMeet(const Eigen::Vector3f& centre, const Eigen::Vector3f& half, const GeomInstance& p,
                      const Vec3& a, VF reach) {
  VF low = hn::Zero(df), high = F(kFar);
  const auto face = [&](VF slope, float room) {  // slope t <= room
    const VF at = hn::Div(F(room), slope);
    const MF rises = hn::Gt(slope, hn::Zero(df));
    high = hn::IfThenElse(rises, hn::Min(high, at), high);
    low = hn::IfThenElse(rises, low, hn::IfThenElse(hn::Lt(slope, hn::Zero(df)), hn::Max(low, at), low));
    if (room < 0) high = hn::IfThenElse(hn::Eq(slope, hn::Zero(df)), F(-1), high);
  };
  const VF along[3] = {a.x, a.y, a.z};
  for (int k = 0; k < 3; ++k) {
    const float from = p.o[k] - centre[k];
    face(hn::Sub(along[k], reach), half[k] - from);
    face(hn::Sub(hn::Neg(along[k]), reach), half[k] + from);
  }
  return hn::And(hn::Le(low, high), hn::Ge(reach, hn::Zero(df)));
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
