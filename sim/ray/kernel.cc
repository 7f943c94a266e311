// SPDX-License-Identifier: Apache-2.0
#include "sim/ray/kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

// Compiled once for each of AVX-512, AVX2 and SSSE3, which is the least that Highway has for x86-64.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/ray/kernel.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kestrel::ray::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using MF = hn::Mask<DF>;
constexpr DF df;
constexpr DI di;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));

constexpr float kFar = 1e8f;  // m: nothing is farther
constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr float kSkyDistance_m = 350;  // of the haze: as far as MuJoCo puts the sky of the OpenGL renderer

constexpr std::uint32_t kOutside = 0x7fffffff;  // codes of a pixel
constexpr std::uint32_t kAlwaysSmooth = 0x80000000;

HWY_INLINE VF F(float x) { return hn::Set(df, x); }

struct Vec3 {
  VF x, y, z;
};
HWY_INLINE Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3 Scale(const Vec3& a, VF s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE VF Dot(const Vec3& a, const Vec3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vec3 Along(const Vec3& o, VF t, const Vec3& d) {
  return {hn::MulAdd(t, d.x, o.x), hn::MulAdd(t, d.y, o.y), hn::MulAdd(t, d.z, o.z)};
}
HWY_INLINE Vec3 Load3(const float* v) { return {F(v[0]), F(v[1]), F(v[2])}; }
// R v, R row after row.
HWY_INLINE Vec3 Rotate(const float* R, const Vec3& v) {
  return {hn::MulAdd(F(R[0]), v.x, hn::MulAdd(F(R[1]), v.y, hn::Mul(F(R[2]), v.z))),
          hn::MulAdd(F(R[3]), v.x, hn::MulAdd(F(R[4]), v.y, hn::Mul(F(R[5]), v.z))),
          hn::MulAdd(F(R[6]), v.x, hn::MulAdd(F(R[7]), v.y, hn::Mul(F(R[8]), v.z)))};
}
HWY_INLINE Vec3 RotateBack(const float* R, const Vec3& v) {
  return {hn::MulAdd(F(R[0]), v.x, hn::MulAdd(F(R[3]), v.y, hn::Mul(F(R[6]), v.z))),
          hn::MulAdd(F(R[1]), v.x, hn::MulAdd(F(R[4]), v.y, hn::Mul(F(R[7]), v.z))),
          hn::MulAdd(F(R[2]), v.x, hn::MulAdd(F(R[5]), v.y, hn::Mul(F(R[8]), v.z)))};
}
HWY_INLINE VF LengthOf(const Vec3& v) { return hn::Sqrt(Dot(v, v)); }

// Rays of one packet with the width of their pixels: the differences to the neighbours' rays.
struct Rays {
  Vec3 d, du, dv;
};

// What of a triangle a ray met; valid in the lanes where a thing of triangles was met last.
struct TriangleHits {
  alignas(64) std::uint32_t face[kLanes];
  alignas(64) float u[kLanes], v[kLanes];
};

struct Hit {
  VF t;
  VI thing;  // -1: none
};

// --- Where a ray enters a shape. Rays that start inside see nothing of it: MuJoCo does not draw backs. ---

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

VF EnterTriangles(const Triangles& triangles, const Vec3& o, const Vec3& d, TriangleHits& hits) {
  RTCRayHit16 packet;
  alignas(64) int valid[16];
  const auto put = [](VF v, float* to) { hn::StoreU(v, df, to); };
  for (int i = 0; i < 16; ++i) valid[i] = i < kLanes ? -1 : 0;
  put(o.x, packet.ray.org_x), put(o.y, packet.ray.org_y), put(o.z, packet.ray.org_z);
  put(d.x, packet.ray.dir_x), put(d.y, packet.ray.dir_y), put(d.z, packet.ray.dir_z);
  put(F(0), packet.ray.tnear), put(F(kFar), packet.ray.tfar), put(F(0), packet.ray.time);
  for (int i = 0; i < kLanes; ++i) {
    packet.ray.mask[i] = ~0u;
    packet.ray.flags[i] = packet.ray.id[i] = 0;
    packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect16(valid, triangles.scene(), &context, &packet);
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

HWY_INLINE VF Enter(const Thing& thing, const Eigen::Vector3f& size, const Vec3& o, const Vec3& d,
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
      return EnterTriangles(*thing.triangles, o, d, hits);
  }
}

// --- What may be seen. ---

// A ray of the tile is o + t d with every |d_k - a_k| <= reach: the thing may be met if for some t >= 0 the
// point o + t a is within half + t reach of its box. Each of the six faces bounds t from one side.
HWY_INLINE MF MayMeet(const Thing& thing, const Placed& p, const Vec3& axis, VF reach) {
  VF low = hn::Zero(df), high = F(kFar);
  const Vec3 a = Rotate(p.R, axis);
  const auto face = [&](VF slope, float room) {  // slope t <= room
    const VF at = hn::Div(F(room), slope);
    const MF rises = hn::Gt(slope, hn::Zero(df));
    high = hn::IfThenElse(rises, hn::Min(high, at), high);
    low = hn::IfThenElse(rises, low, hn::IfThenElse(hn::Lt(slope, hn::Zero(df)), hn::Max(low, at), low));
    if (room < 0) high = hn::IfThenElse(hn::Eq(slope, hn::Zero(df)), F(-1), high);
  };
  const VF along[3] = {a.x, a.y, a.z};
  for (int k = 0; k < 3; ++k) {
    const float from = p.o[k] - thing.box_centre[k];
    face(hn::Sub(along[k], reach), thing.box_half[k] - from);
    face(hn::Sub(hn::Neg(along[k]), reach), thing.box_half[k] + from);
  }
  return hn::And(hn::Le(low, high), hn::Ge(reach, hn::Zero(df)));
}

// --- Textures. ---

struct Colours {
  VF r, g, b;  // 0 to 255
};

// Level of a pyramid, in each lane its own.
struct LevelOf {
  VF width, height;
  VI stride, offset;
};

HWY_INLINE LevelOf Level(const Pyramid& p, VI level, bool same, int first) {
  if (same) {
    return {F(p.width[first]), F(p.height[first]), hn::Set(di, p.stride[first]),
            hn::Set(di, p.offset[first])};
  }
  return {hn::GatherIndex(df, p.width, level), hn::GatherIndex(df, p.height, level),
          hn::GatherIndex(di, p.stride, level), hn::GatherIndex(di, p.offset, level)};
}

constexpr float kWeightScale = 16384;

// Places of the four texels round (s, t) in 0 to 1 and their weights, in pairs: 16 bits each, left below
// right.
struct Taps {
  alignas(64) std::int32_t offset[kLanes], below[kLanes], upper[kLanes], lower[kLanes];
};

HWY_INLINE void MakeTaps(const LevelOf& level, VF s, VF t, VI face, Taps& taps) {
  const VF x = hn::MulSub(s, level.width, F(0.5f)), y = hn::MulSub(t, level.height, F(0.5f));
  const VF xf = hn::Min(hn::Max(hn::Floor(x), F(-1)), hn::Sub(level.width, F(1)));
  const VF yf = hn::Min(hn::Max(hn::Floor(y), F(-1)), hn::Sub(level.height, F(1)));
  const VF fx = hn::Min(hn::Max(hn::Sub(x, xf), hn::Zero(df)), F(1));
  const VF low = hn::Mul(hn::Min(hn::Max(hn::Sub(y, yf), hn::Zero(df)), F(1)), F(kWeightScale));
  const VF up = hn::Sub(F(kWeightScale), low);
  const VI offset = hn::Add(hn::Add(level.offset, face),
                            hn::Add(hn::Mul(hn::ConvertTo(di, yf), level.stride), hn::ConvertTo(di, xf)));
  const auto pair = [&](VF row) {
    const VF right = hn::Mul(row, fx);
    return hn::Or(hn::NearestInt(hn::Sub(row, right)), hn::ShiftLeft<16>(hn::NearestInt(right)));
  };
  hn::Store(offset, di, taps.offset);
  hn::Store(hn::Add(offset, level.stride), di, taps.below);
  hn::Store(pair(up), di, taps.upper);
  hn::Store(pair(low), di, taps.lower);
}

// log2 to 0.01, of positive numbers.
HWY_INLINE VF Log2(VF x) {
  const VI bits = hn::BitCast(di, x);
  const VF exponent = hn::ConvertTo(df, hn::Sub(hn::ShiftRight<23>(bits), hn::Set(di, 127)));
  const VF m = hn::BitCast(df, hn::Or(hn::And(bits, hn::Set(di, 0x7fffff)), hn::Set(di, 0x3f800000)));
  return hn::Add(exponent, hn::MulAdd(hn::MulAdd(m, F(-1.0f / 3), F(2)), m, F(-5.0f / 3)));
}

// Which texels a packet mixes: planned with all lanes at once, fetched one by one. The two are apart so that
// the processor can plan for one packet while it waits for the texels of others.
struct Fetch {
  Taps taps;
  const std::uint32_t* texels = nullptr;  // null: no texture
};

// From the level of the pyramid that suits the footprint, between its four nearest texels. s, t in 0 to 1;
// footprint2: the width of a pixel in texels of the whole picture, squared; face: offset of the cube's face.
HWY_INLINE void Plan(const Pyramid& p, VF s, VF t, VF footprint2, VI face, MF wanted, Fetch& fetch) {
  // Exponent and first bit of the mantissa: half octaves of the square.
  const VI halves = hn::Sub(hn::ShiftRight<22>(hn::BitCast(di, footprint2)), hn::Set(di, (127 << 1) - 1));
  const VI level = hn::Min(hn::Max(halves, hn::Zero(di)), hn::Set(di, p.levels - 1));
  alignas(64) std::int32_t levels[kLanes];
  hn::Store(level, di, levels);
  const int first = levels[hn::FindFirstTrue(df, wanted)];
  const bool same =
      hn::AllTrue(df, hn::Or(hn::Not(wanted), hn::RebindMask(df, hn::Eq(level, hn::Set(di, first)))));
  MakeTaps(Level(p, level, same, first), s, t, face, fetch.taps);
  fetch.texels = p.texels.data();
}

// Two texels from each of two places, for so many pixels: one block of 16 bytes each.
template <int blocks>
HWY_INLINE auto Blocks(const std::uint32_t* texels, const std::int32_t* above, const std::int32_t* below) {
  if constexpr (blocks == 1) {
    const hn::FixedTag<std::uint64_t, 2> d;
    std::uint64_t two[2];
    std::memcpy(two, texels + above[0], 8);
    std::memcpy(two + 1, texels + below[0], 8);
    return hn::InterleaveLower(d, hn::Set(d, two[0]), hn::Set(d, two[1]));
  } else {
    const hn::FixedTag<std::uint64_t, 2 * blocks> d;
    return hn::Combine(d, Blocks<blocks / 2>(texels, above + blocks / 2, below + blocks / 2),
                       Blocks<blocks / 2>(texels, above, below));
  }
}

// Each number over a block of its own.
template <int blocks>
HWY_INLINE auto Spread(const std::int32_t* numbers) {
  if constexpr (blocks == 1) {
    return hn::Set(hn::FixedTag<std::int32_t, 4>(), numbers[0]);
  } else {
    const hn::FixedTag<std::int32_t, 4 * blocks> d;
    return hn::Combine(d, Spread<blocks / 2>(numbers + blocks / 2), Spread<blocks / 2>(numbers));
  }
}

// Mixes the four texels of each lane: mixed + 4 lane is blue, green, red, 0, times kWeightScale. Every lane
// has a place in the picture, wanted or not. A block of 16 bytes holds the upper and the lower two texels of
// one lane.
HWY_INLINE void Mix(const Fetch& fetch, std::int32_t* mixed) {
  const hn::Repartition<std::uint8_t, DF> d8;
  const hn::Repartition<std::int16_t, DF> d16;
  constexpr int kBlocks = kLanes / 4;
  // Of two texels side by side, channel by channel, 16 bits each: b b' g g' r r' 0 0.
  alignas(16) static constexpr std::uint8_t kUpper[16] = {0, 0x80, 4, 0x80, 1, 0x80, 5, 0x80,
                                                          2, 0x80, 6, 0x80, 3, 0x80, 7, 0x80};
  alignas(16) static constexpr std::uint8_t kLower[16] = {8,  0x80, 12, 0x80, 9,  0x80, 13, 0x80,
                                                          10, 0x80, 14, 0x80, 11, 0x80, 15, 0x80};
  const auto upper = hn::LoadDup128(d8, kUpper), lower = hn::LoadDup128(d8, kLower);
  const Taps& taps = fetch.taps;
  for (int i = 0; i < kLanes; i += kBlocks) {
    const auto texels = hn::BitCast(d8, Blocks<kBlocks>(fetch.texels, taps.offset + i, taps.below + i));
    const auto weights = [&](const std::int32_t* of) { return hn::BitCast(d16, Spread<kBlocks>(of + i)); };
    auto none = hn::Zero(di);
    const VI sum = hn::ReorderWidenMulAccumulate(di, hn::BitCast(d16, hn::TableLookupBytesOr0(texels, upper)),
                                                 weights(taps.upper), hn::Zero(di), none);
    hn::Store(hn::ReorderWidenMulAccumulate(di, hn::BitCast(d16, hn::TableLookupBytesOr0(texels, lower)),
                                            weights(taps.lower), sum, none),
              di, mixed + 4 * i);
  }
}

HWY_INLINE Colours Unpack(const std::int32_t* mixed) {
  VI b, g, r, unused;
  hn::LoadInterleaved4(di, mixed, b, g, r, unused);
  const VF scale = F(1 / kWeightScale);
  return {hn::Mul(hn::ConvertTo(df, r), scale), hn::Mul(hn::ConvertTo(df, g), scale),
          hn::Mul(hn::ConvertTo(df, b), scale)};
}

HWY_INLINE std::uint32_t BitsOf(MF mask) {
  std::uint8_t lanes[8] = {};
  hn::StoreMaskBits(df, mask, lanes);
  return (lanes[0] | lanes[1] << 8) & ((1u << kLanes) - 1);
}

// The longer side of a pixel's footprint, in texels, squared.
HWY_INLINE VF Footprint2(const Pyramid& p, VF s_u, VF t_u, VF s_v, VF t_v) {
  const VF w = F(p.width[0]), h = F(p.height[0]);
  const VF a = hn::Mul(s_u, w), b = hn::Mul(t_u, h), c = hn::Mul(s_v, w), d = hn::Mul(t_v, h);
  return hn::Max(hn::MulAdd(a, a, hn::Mul(b, b)), hn::MulAdd(c, c, hn::Mul(d, d)));
}

HWY_INLINE void PlanRepeating(const Pyramid& p, VF s, VF t, VF s_u, VF t_u, VF s_v, VF t_v, MF wanted,
                              Fetch& fetch) {
  Plan(p, hn::Sub(s, hn::Floor(s)), hn::Sub(t, hn::Floor(t)), Footprint2(p, s_u, t_u, s_v, t_v), hn::Zero(di),
       wanted, fetch);
}

// By direction, as OpenGL numbers and turns the faces of a cube.
HWY_INLINE void PlanCube(const Pyramid& p, const Vec3& q, const Vec3& q_u, const Vec3& q_v, MF wanted,
                         Fetch& fetch) {
  const VF ax = hn::Abs(q.x), ay = hn::Abs(q.y), az = hn::Abs(q.z);
  const MF on_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
  const MF on_y = hn::AndNot(on_x, hn::Ge(ay, az));
  // (sc, tc, ma): the two across and the major one, without their signs, of any vector.
  const auto across = [&](const Vec3& v) {
    return Vec3{hn::IfThenElse(on_x, v.z, v.x), hn::IfThenElse(on_y, v.z, v.y),
                hn::IfThenElse(on_x, v.x, hn::IfThenElse(on_y, v.y, v.z))};
  };
  const Vec3 c = across(q), c_u = across(q_u), c_v = across(q_v);
  const MF negative = hn::Lt(c.z, hn::Zero(df));
  const VF sign = hn::IfThenElse(negative, F(-1), F(1));
  // sc: -z, z on x; x, x on y; x, -x on z.   tc: -y, -y on x; z, -z on y; -y, -y on z.
  const VF sign_s = hn::IfThenElse(on_x, hn::Neg(sign), hn::IfThenElse(on_y, F(1), sign));
  const VF sign_t = hn::IfThenElse(on_y, sign, F(-1));
  const VF inverse = hn::Div(F(0.5f), hn::Max(hn::Abs(c.z), F(1e-30f)));
  const VF s = hn::MulAdd(hn::Mul(sign_s, c.x), inverse, F(0.5f));
  const VF t = hn::MulAdd(hn::Mul(sign_t, c.y), inverse, F(0.5f));
  const VF ratio_x = hn::Div(c.x, c.z), ratio_y = hn::Div(c.y, c.z);
  const auto change = [&](VF part, VF ratio, VF major) {
    return hn::Mul(hn::NegMulAdd(ratio, major, part), inverse);
  };
  const VF footprint2 = Footprint2(p, change(c_u.x, ratio_x, c_u.z), change(c_u.y, ratio_y, c_u.z),
                                   change(c_v.x, ratio_x, c_v.z), change(c_v.y, ratio_y, c_v.z));
  const VF face = hn::Add(hn::IfThenElse(on_x, F(0), hn::IfThenElse(on_y, F(2), F(4))),
                          hn::IfThenElse(negative, F(1), F(0)));
  Plan(p, s, t, footprint2, hn::Mul(hn::ConvertTo(di, face), hn::Set(di, p.face_stride)), wanted, fetch);
}

// --- Light. ---

// Which rays from the points to the light (directions not normalised; t up to reach) meet something opaque.
MF InShadow(const Slice& slice, const Vec3& p_C, const Vec3& d_C, VF reach, MF wanted) {
  MF dark = hn::Lt(F(1), F(0));
  TriangleHits unused;
  for (std::size_t i = 0; i < slice.things->all.size(); ++i) {
    const Placed& placed = slice.placement->things[i];
    if (placed.transparent) continue;
    const Thing& thing = slice.things->all[i];
    const Vec3 o = Rotate(placed.R, p_C) + Load3(placed.o), d = Rotate(placed.R, d_C);
    dark = hn::Or(dark, hn::Lt(Enter(thing, thing.size, o, d, unused), reach));
    if (hn::AllTrue(df, hn::Or(dark, hn::Not(wanted)))) break;
  }
  return dark;
}

// Light on the points, 0 to 1 of the thing's colour, each channel; normals of length 1, in C. Shadows are
// marked in the side.
HWY_INLINE Colours Light(const Slice& slice, const Thing& thing, const Vec3& p, const Vec3& n, const Vec3& d,
                         MF wanted, VI& side) {
  const Things& things = *slice.things;
  const VF none = things.lit ? hn::Zero(df) : F(0.3f);
  const auto start = [&](int k) { return hn::Mul(F(thing.rgba[k]), hn::Add(none, F(thing.emission))); };
  VF sum[3] = {start(0), start(1), start(2)};
  for (std::size_t i = 0; i < things.lights.size(); ++i) {
    const ray::Light& light = things.lights[i];
    const PlacedLight& placed = slice.placement->lights[i];
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

// --- The colour of a surface. ---

// A surface lit, 0 to 255, and the texels that colour it.
struct Surface {
  Colours lit;
  VI side;  // which of the thing's sides, for telling edges
  Fetch fetch;
};

// Normal in G at the point p_G, and the side.
HWY_INLINE void NormalOf(const Thing& thing, const Vec3& p, const TriangleHits& hits, MF wanted, Vec3& n,
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
      std::uint8_t lanes[8] = {};
      hn::StoreMaskBits(df, wanted, lanes);
      for (int i = 0; i < kLanes; ++i) {
        if (!(lanes[i / 8] >> (i % 8) & 1)) continue;
        const Triangles::Corner* corner =
            &thing.triangles->corners[3 * static_cast<std::size_t>(hits.face[i])];
        const Eigen::Vector3f normal = (1 - hits.u[i] - hits.v[i]) * corner[0].normal +
                                       hits.u[i] * corner[1].normal + hits.v[i] * corner[2].normal;
        x[i] = normal.x(), y[i] = normal.y(), z[i] = normal.z();
      }
      n = {hn::Load(df, x), hn::Load(df, y), hn::Load(df, z)};
      n = Scale(n, hn::Div(one, hn::Max(LengthOf(n), F(1e-30f))));
      // A crease shows by a turn of the normal.
      const auto part = [&](VF v) { return hn::NearestInt(hn::MulAdd(v, F(3), F(3))); };
      side = hn::Or(part(n.x), hn::Or(hn::ShiftLeft<3>(part(n.y)), hn::ShiftLeft<6>(part(n.z))));
      return;
    }
  }
  n = Scale(n, hn::Div(one, hn::Max(LengthOf(n), F(1e-30f))));
}

// How the point on a surface moves from a pixel to its neighbour, whose ray differs by e.
class Steps {
 public:
  HWY_INLINE Steps(const Thing& thing, const Vec3& d, const Vec3& n, VF t) : d_(d), n_(n), t_(t) {
    is_plane_ = thing.type == mjGEOM_PLANE;
    const VF n_d = is_plane_ ? d.z : Dot(n, d);
    // Near the outline the surface is seen edge on, and the linear step would be endless.
    const VF steep = hn::IfThenElse(hn::Lt(hn::Abs(n_d), F(1e-4f)), hn::CopySign(F(1e-4f), n_d), n_d);
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
  const Thing& thing = slice.things->all[index];
  const Placed& placed = slice.placement->things[index];
  const bool flat = placed.flat && !(slice.shadows && slice.things->lit);
  const auto constant = [&](int side) {
    const float* c = placed.face[side];
    return Colours{F(c[0]), F(c[1]), F(c[2])};
  };
  t = hn::IfThenElse(wanted, t, F(1));
  surface.fetch.texels = nullptr;
  if (flat && thing.type == mjGEOM_PLANE && !thing.texture) {
    surface.lit = constant(4);
    surface.side = hn::Set(di, 4);
    return;
  }
  const Vec3 d = Rotate(placed.R, rays.d);
  const Vec3 p = Along(Load3(placed.o), t, d);
  Vec3 n;
  NormalOf(thing, p, hits, wanted, n, surface.side);
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
  } else {
    colour = Light(slice, thing, Scale(rays.d, t), RotateBack(placed.R, n), rays.d, wanted, surface.side);
    const VF whole = F(255);
    colour = {hn::Mul(colour.r, whole), hn::Mul(colour.g, whole), hn::Mul(colour.b, whole)};
  }
  if (!thing.texture) return;

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
      std::uint8_t lanes[8] = {};
      hn::StoreMaskBits(df, wanted, lanes);
      for (int i = 0; i < kLanes; ++i) {
        if (!(lanes[i / 8] >> (i % 8) & 1)) continue;
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
  surface.fetch.texels = nullptr;
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
  if (!surface.fetch.texels) return surface.lit;
  alignas(64) std::int32_t mixed[4 * kLanes];
  Mix(surface.fetch, mixed);
  return Tinted(surface.lit, mixed);
}

HWY_INLINE Colours Over(const Colours& above, VF alpha, const Colours& below, MF where) {
  const VF a = hn::IfThenElseZero(where, alpha);
  const auto mix = [&](VF x, VF y) { return hn::MulAdd(a, hn::Sub(x, y), y); };
  return {mix(above.r, below.r), mix(above.g, below.g), mix(above.b, below.b)};
}

// Where the haze is, a ray below the horizon: 0 at the horizon, 1 where it stands on the plane; and how far
// away.
HWY_INLINE void HazeAt(const Placed& plane, float width, const Vec3& d, VF& u, VF& down, VF& distance) {
  const VF up = Rotate(plane.R, d).z;
  const VF level = hn::Sqrt(hn::Max(hn::NegMulAdd(up, up, Dot(d, d)), F(1e-20f)));
  u = hn::Div(hn::Mul(hn::Neg(up), F(kSkyDistance_m / plane.o[2])), level);
  down = hn::Div(u, hn::MulAdd(u, F(width), F(1)));
  distance = hn::Div(hn::Mul(hn::NegMulAdd(down, F(width), F(1)), F(kSkyDistance_m)), level);
}

// Behind the haze an endless plane gives way to the sky, into which the haze fades.
HWY_INLINE void EndPlane(const Slice& slice, const Vec3& d, Hit& hit) {
  const Haze& haze = slice.things->haze;
  if (haze.thing < 0) return;
  const Placed& plane = slice.placement->things[haze.thing];
  if (!(plane.o[2] > 0)) return;
  VF u, down, distance;
  HazeAt(plane, haze.width, d, u, down, distance);
  const MF beyond = hn::And(hn::Lt(u, F(1)), hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, haze.thing))));
  hit.thing = hn::IfThenElse(hn::RebindMask(di, beyond), hn::Set(di, -1), hit.thing);
  hit.t = hn::IfThenElse(beyond, F(kNone), hit.t);
}

// A truncated cone round the viewpoint, from the height of the plane up to the horizon, faded at both ends.
Colours Hazed(const Slice& slice, const Rays& rays, VF t, const Colours& below) {
  const Haze& haze = slice.things->haze;
  const Placed& plane = slice.placement->things[haze.thing];
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

// --- Packets. ---

// The things that a tile may see.
struct Seen {
  std::vector<int> opaque, transparent;
  bool thin = false;  // some are so thin that a pixel's ray may miss them
};

// A rod or a dot less than about two pixels wide.
bool IsThin(const Slice& slice, int index) {
  const Thing& thing = slice.things->all[index];
  if (thing.type == mjGEOM_PLANE || thing.triangles) return false;
  Eigen::Vector3f half = thing.box_half;
  std::sort(half.data(), half.data() + 3);
  const float nearest = std::max(slice.placement->things[index].distance - thing.box_half.norm(), 0.0f);
  return half[1] < slice.lens->pixel_rad * nearest;
}

void ListSeen(const Slice& slice, int tile_column, Seen& seen) {
  seen.opaque.clear();
  seen.transparent.clear();
  seen.thin = false;
  const std::uint64_t* words = slice.seen + static_cast<std::ptrdiff_t>(tile_column) * slice.words;
  for (int w = 0; w < slice.words; ++w) {
    for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
      const int i = 64 * w + std::countr_zero(bits);
      if (slice.placement->things[i].transparent) continue;
      seen.opaque.push_back(i);
      seen.thin = seen.thin || IsThin(slice, i);
    }
  }
  for (const int i : slice.placement->transparent) {
    if (!(words[i / 64] >> (i % 64) & 1)) continue;
    seen.transparent.push_back(i);
    seen.thin = seen.thin || IsThin(slice, i);
  }
}

HWY_INLINE Hit Trace(const Slice& slice, const Seen& seen, const Vec3& d_C, TriangleHits& triangles) {
  Hit hit{F(kNone), hn::Set(di, -1)};
  for (const int i : seen.opaque) {
    const Thing& thing = slice.things->all[i];
    const Placed& placed = slice.placement->things[i];
    TriangleHits own;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, d_C), own);
    const MF nearer = hn::Lt(t, hit.t);
    hit.t = hn::IfThenElse(nearer, t, hit.t);
    hit.thing = hn::IfThenElse(hn::RebindMask(di, nearer), hn::Set(di, i), hit.thing);
    if (thing.triangles) {
      const auto keep = [&](const auto& from, auto& to, auto d) {
        hn::Store(hn::IfThenElse(hn::RebindMask(d, nearer), hn::Load(d, from), hn::Load(d, to)), d, to);
      };
      const hn::RebindToUnsigned<DF> du;
      keep(own.face, triangles.face, du);
      keep(own.u, triangles.u, df);
      keep(own.v, triangles.v, df);
    }
  }
  return hit;
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
  if (slice.things->all[index].triangles) {
    // What is in front of itself shows by a leap of the distance.
    const VF octave = hn::Mul(F(4), Log2(hn::IfThenElse(wanted, t, F(1))));
    const VI leap = hn::And(hn::ConvertTo(di, hn::Floor(octave)), hn::Set(di, 255));
    surface.side = hn::Or(surface.side, hn::ShiftLeft<9>(leap));
  }
}

HWY_INLINE VI CodeOf(const Surface& surface, int index) {
  return hn::Add(hn::ShiftLeft<12>(surface.side), hn::Set(di, index + 1));
}

// Colours of a packet: what is opaque, the sky behind, haze, what is transparent.
HWY_NOINLINE Picture Look(const Slice& slice, const Seen& seen, const Rays& rays, const Hit& hit,
                          const TriangleHits& triangles, MF wanted) {
  Picture picture{{hn::Zero(df), hn::Zero(df), hn::Zero(df)}, hn::Zero(di)};
  alignas(64) std::int32_t index[kLanes];
  hn::Store(hit.thing, di, index);
  Surface surface;
  MF left = wanted;
  while (!hn::AllFalse(df, left)) {
    const int i = index[hn::FindFirstTrue(df, left)];
    const MF here = hn::And(left, hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, i))));
    left = hn::AndNot(here, left);
    ShadeHit(slice, i, rays, hit.t, triangles, here, surface);
    const Colours c = Finish(surface);
    picture.colour = {hn::IfThenElse(here, c.r, picture.colour.r),
                      hn::IfThenElse(here, c.g, picture.colour.g),
                      hn::IfThenElse(here, c.b, picture.colour.b)};
    picture.code = hn::IfThenElse(hn::RebindMask(di, here), CodeOf(surface, i), picture.code);
  }
  if (slice.things->haze.thing >= 0) picture.colour = Hazed(slice, rays, hit.t, picture.colour);

  // As MuJoCo draws them: all from front to back, then all from back to front.
  const int layers = static_cast<int>(seen.transparent.size());
  for (int k = 0; k < 2 * layers; ++k) {
    const int i = seen.transparent[k < layers ? k : 2 * layers - 1 - k];
    const Thing& thing = slice.things->all[i];
    const Placed& placed = slice.placement->things[i];
    TriangleHits own;
    const VF t = Enter(thing, thing.size, Load3(placed.o), Rotate(placed.R, rays.d), own);
    const MF here = hn::And(wanted, hn::Lt(t, hit.t));
    if (hn::AllFalse(df, here)) continue;
    Shade(slice, i, rays, t, own, here, surface);
    picture.colour = Over(Finish(surface), F(placed.alpha), picture.colour, here);
    const VI mark = hn::Set(di, static_cast<std::int32_t>((i + 1) * 0x9e3779b1u & 0x0fffffff));
    picture.code = hn::Add(picture.code, hn::IfThenElseZero(hn::RebindMask(di, here), mark));
  }
  picture.code = hn::And(picture.code, hn::Set(di, 0x3fffffff));
  return picture;
}

// Of a colour, which is in 0 to 255 by its making.
HWY_INLINE VI Rounded(VF colour) { return hn::NearestInt(colour); }

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

// Rays that pass so near a thin thing that it covers part of their pixel.
MF NearThin(const Slice& slice, const Seen& seen, const Vec3& d) {
  MF near = hn::Lt(F(1), F(0));
  TriangleHits unused;
  const auto add = [&](int i) {
    if (!IsThin(slice, i)) return;
    const Thing& thing = slice.things->all[i];
    const Placed& placed = slice.placement->things[i];
    const float room = slice.lens->pixel_rad * (placed.distance + thing.box_half.norm());
    const Eigen::Vector3f wider = thing.size + Eigen::Vector3f::Constant(room);
    near = hn::Or(near, hn::Lt(Enter(thing, wider, Load3(placed.o), Rotate(placed.R, d), unused), F(kFar)));
  };
  for (const int i : seen.opaque) add(i);
  for (const int i : seen.transparent) add(i);
  return near;
}

const char* Name() { return hwy::TargetName(HWY_TARGET); }

void CullImpl(const Slice& slice, int tile_row) {
  const Lens& lens = *slice.lens;
  std::fill(slice.seen, slice.seen + static_cast<std::ptrdiff_t>(lens.tiles_x) * slice.words, 0);
  const int first = tile_row * lens.tiles_x;
  for (std::size_t i = 0; i < slice.things->all.size(); ++i) {
    const Thing& thing = slice.things->all[i];
    const Placed& placed = slice.placement->things[i];
    for (int c = 0; c < lens.tiles_x; c += kLanes) {
      const auto load = [&](const Aligned<float>& v) { return hn::LoadU(df, v.get() + first + c); };
      const Vec3 axis{load(lens.axis_x), load(lens.axis_y), load(lens.axis_z)};
      const MF may = MayMeet(thing, placed, axis, load(lens.reach));
      std::uint8_t lanes[8] = {};
      hn::StoreMaskBits(df, may, lanes);
      std::uint32_t bits = lanes[0] | lanes[1] << 8;
      bits &= (1u << kLanes) - 1;
      for (; bits != 0; bits &= bits - 1) {
        const int column = c + std::countr_zero(bits);
        if (column >= lens.tiles_x) break;
        slice.seen[static_cast<std::ptrdiff_t>(column) * slice.words + static_cast<std::ptrdiff_t>(i / 64)] |=
            std::uint64_t{1} << (i % 64);
      }
    }
  }
}

// A packet of a row that shows one thing alone, planned but not yet fetched.
struct Job {
  Surface surface;
  alignas(64) std::int32_t mixed[4 * kLanes];
  MF inside;
  std::uint8_t* to = nullptr;
  int pixels = 0;
};

HWY_INLINE void StorePixels(const Colours& colour, MF inside, int pixels, std::uint8_t* to) {
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

void DrawRowsImpl(const Slice& slice, int begin, int end, const Canvas& canvas) {
  const Lens& lens = *slice.lens;
  const int tile_row = begin / Lens::kTile;
  std::vector<Seen> seen(lens.tiles_x);
  for (int column = 0; column < lens.tiles_x; ++column) ListSeen(slice, column, seen[column]);
  const auto jobs =
      hwy::MakeUniqueAlignedArray<Job>(static_cast<std::size_t>(lens.tiles_x) * (Lens::kTile / kLanes));
  // Row by row, as the table and the image lie in memory.
  for (int v = begin; v < end; ++v) {
    int planned = 0;
    for (int column = 0; column < lens.tiles_x; ++column) {
      const int u0 = column * Lens::kTile;
      std::uint8_t* row = canvas.bgr + v * canvas.step + 3 * static_cast<std::size_t>(u0);
      std::uint32_t* codes = canvas.code + static_cast<std::ptrdiff_t>(v) * lens.stride + u0;
      std::uint32_t& common = canvas.common[static_cast<std::ptrdiff_t>(v) * lens.tiles_x + column];
      common = Canvas::kMixed;
      if (lens.reach[tile_row * lens.tiles_x + column] < 0) {
        std::memset(row, 0, 3 * static_cast<std::size_t>(std::min(Lens::kTile, lens.width - u0)));
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
          std::memset(row + 3 * k, 0, 3 * static_cast<std::size_t>(pixels));
          std::fill(codes + k, codes + k + kLanes, kOutside);
          continue;
        }
        const Rays rays = RaysAt(lens, at);
        TriangleHits triangles;
        Hit hit = Trace(slice, here, rays.d, triangles);
        EndPlane(slice, rays.d, hit);
        VI code;
        alignas(64) std::int32_t index[kLanes];
        hn::Store(hit.thing, di, index);
        const int first = index[hn::FindFirstTrue(df, inside)];
        const bool alone = hn::AllTrue(
            df, hn::Or(hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, first))), hn::Not(inside)));
        if (alone && here.transparent.empty() && slice.things->haze.thing < 0) {
          Job& job = jobs[planned++];
          ShadeHit(slice, first, rays, hit.t, triangles, inside, job.surface);
          job.inside = inside;
          job.to = row + 3 * k;
          job.pixels = pixels;
          code = hn::And(CodeOf(job.surface, first), hn::Set(di, 0x3fffffff));
        } else {
          const Picture picture = Look(slice, here, rays, hit, triangles, inside);
          StorePixels(picture.colour, inside, pixels, row + 3 * k);
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
      StorePixels(job.surface.fetch.texels ? Tinted(lit, job.mixed) : lit, job.inside, job.pixels, job.to);
    }
  }
}

// Sixteen places in a pixel, each in a column and a row of its own.
constexpr int kSubpixels = 16;
alignas(64) constexpr float kAcross[kSubpixels] = {
    -15 / 32.f, -13 / 32.f, -11 / 32.f, -9 / 32.f, -7 / 32.f, -5 / 32.f, -3 / 32.f, -1 / 32.f,
    1 / 32.f,   3 / 32.f,   5 / 32.f,   7 / 32.f,  9 / 32.f,  11 / 32.f, 13 / 32.f, 15 / 32.f};
alignas(64) constexpr float kDown[kSubpixels] = {
    -15 / 32.f, 1 / 32.f, -7 / 32.f, 9 / 32.f,  -11 / 32.f, 5 / 32.f, -3 / 32.f, 13 / 32.f,
    -13 / 32.f, 3 / 32.f, -5 / 32.f, 11 / 32.f, -9 / 32.f,  7 / 32.f, -1 / 32.f, 15 / 32.f};

void SmoothPixel(const Slice& slice, const Seen& seen, std::ptrdiff_t at, std::uint8_t* bgr) {
  const Lens& lens = *slice.lens;
  const auto ray = [&](std::ptrdiff_t i) { return Vec3{F(lens.x[i]), F(lens.y[i]), F(lens.z[i])}; };
  const Vec3 middle = ray(at), across = ray(at + 1) - middle, down = ray(at + lens.stride) - middle;
  const MF all = hn::Eq(middle.x, middle.x);
  float sum[3] = {};
  for (int k = 0; k < kSubpixels; k += kLanes) {
    Rays rays;
    rays.d = Along(Along(middle, hn::Load(df, kAcross + k), across), hn::Load(df, kDown + k), down);
    rays.du = Scale(across, F(0.5f));
    rays.dv = Scale(down, F(0.5f));
    TriangleHits triangles;
    Hit hit = Trace(slice, seen, rays.d, triangles);
    EndPlane(slice, rays.d, hit);
    const Colours c = Look(slice, seen, rays, hit, triangles, all).colour;
    sum[0] += hn::GetLane(hn::SumOfLanes(df, c.b));
    sum[1] += hn::GetLane(hn::SumOfLanes(df, c.g));
    sum[2] += hn::GetLane(hn::SumOfLanes(df, c.r));
  }
  for (int k = 0; k < 3; ++k)
    bgr[k] = static_cast<std::uint8_t>(std::lround(std::clamp(sum[k] / kSubpixels, 0.0f, 255.0f)));
}

void SmoothRowImpl(const Slice& slice, int v, const Canvas& canvas) {
  const Lens& lens = *slice.lens;
  const std::uint32_t* row = canvas.code + static_cast<std::ptrdiff_t>(v) * lens.stride;
  const std::uint32_t* above = v > 0 ? row - lens.stride : row;
  const std::uint32_t* below = v + 1 < lens.height ? row + lens.stride : row;
  Seen seen;
  const auto load = [&](const std::uint32_t* p) {
    return hn::LoadU(di, reinterpret_cast<const std::int32_t*>(p));
  };
  const VI outside = hn::Set(di, static_cast<std::int32_t>(kOutside));
  const std::uint32_t* common = canvas.common + static_cast<std::ptrdiff_t>(v) * lens.tiles_x;
  for (int column = 0; column < lens.tiles_x; ++column) {
    const int left = column * Lens::kTile, right = left + Lens::kTile;
    const std::uint32_t one = common[column];
    if (one < kAlwaysSmooth && above[left] == one && below[left] == one &&
        (v == 0 || common[column - lens.tiles_x] == one) &&
        (v + 1 == lens.height || common[column + lens.tiles_x] == one) &&
        (left == 0 || row[left - 1] == one) && (right >= lens.width || row[right] == one)) {
      continue;
    }
    bool listed = false;
    for (int k = 0; k < Lens::kTile; k += kLanes) {
      const int u = column * Lens::kTile + k;
      if (u >= lens.width) break;
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
      std::uint8_t lanes[8] = {};
      hn::StoreMaskBits(di, edge, lanes);
      std::uint32_t bits = (lanes[0] | lanes[1] << 8) & ((1u << kLanes) - 1);
      for (; bits != 0; bits &= bits - 1) {
        const int at = u + std::countr_zero(bits);
        if (at >= lens.width) break;
        if (!listed) ListSeen(slice, column, seen);
        listed = true;
        SmoothPixel(slice, seen, static_cast<std::ptrdiff_t>(v) * lens.stride + at,
                    canvas.bgr + v * canvas.step + 3 * static_cast<std::size_t>(at));
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
        const Hit hit = Trace(slice, seen, rays.d, unused);
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
}  // namespace kestrel::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kestrel::ray {

HWY_EXPORT(Name);
HWY_EXPORT(CullImpl);
HWY_EXPORT(DrawRowsImpl);
HWY_EXPORT(SmoothRowImpl);
HWY_EXPORT(SeeRowsImpl);

const char* InstructionSet() { return HWY_DYNAMIC_DISPATCH(Name)(); }
void Cull(const Slice& slice, int tile_row) { HWY_DYNAMIC_DISPATCH(CullImpl)(slice, tile_row); }
void DrawRows(const Slice& slice, int begin, int end, const Canvas& canvas) {
  HWY_DYNAMIC_DISPATCH(DrawRowsImpl)(slice, begin, end, canvas);
}
void SmoothRow(const Slice& slice, int row, const Canvas& canvas) {
  HWY_DYNAMIC_DISPATCH(SmoothRowImpl)(slice, row, canvas);
}
void SeeRows(const Slice& slice, int begin, int end, float* depth_m, std::int32_t* geom, std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(SeeRowsImpl)(slice, begin, end, depth_m, geom, stride);
}

}  // namespace kestrel::ray
#endif
