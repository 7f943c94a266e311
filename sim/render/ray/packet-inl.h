// SPDX-License-Identifier: Apache-2.0
// Packets of rays: as many as a vector is wide, at most 16.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_PACKET_INL_H_
#undef KESTREL_SIM_RAY_PACKET_INL_H_
#else
#define KESTREL_SIM_RAY_PACKET_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
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
HWY_INLINE Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE VF LengthOf(const Vec3& v) { return hn::Sqrt(Dot(v, v)); }

// Rays of one packet with the width of their pixels: the differences to the neighbours' rays.
struct Rays {
  Vec3 d, du, dv;
};

HWY_INLINE std::uint32_t BitsOf(MF mask) {
  std::uint8_t lanes[8] = {};
  hn::StoreMaskBits(df, mask, lanes);
  return (lanes[0] | lanes[1] << 8) & ((1u << kLanes) - 1);
}

// log2 to 0.01, of positive numbers.
HWY_INLINE VF Log2(VF x) {
  const VI bits = hn::BitCast(di, x);
  const VF exponent = hn::ConvertTo(df, hn::Sub(hn::ShiftRight<23>(bits), hn::Set(di, 127)));
  const VF m = hn::BitCast(df, hn::Or(hn::And(bits, hn::Set(di, 0x7fffff)), hn::Set(di, 0x3f800000)));
  return hn::Add(exponent, hn::MulAdd(hn::MulAdd(m, F(-1.0f / 3), F(2)), m, F(-5.0f / 3)));
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
