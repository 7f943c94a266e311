// SPDX-License-Identifier: Apache-2.0
// Detail of level ground: blades and tufts of grass, grain of what is not green.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_GRASS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_GRASS_INL_H_
#undef KESTREL_SIM_RAY_GRASS_INL_H_
#else
#define KESTREL_SIM_RAY_GRASS_INL_H_
#endif

#include "sim/render/ray/packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

constexpr std::int32_t kColumn = 0x27d4eb2d, kRow = 0x165667b1;

// -1 to 1, of a corner of the lattice; h: its column times kColumn plus its row times kRow.
HWY_INLINE VF Corner(VI h) {
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(di, 0x2c1b3c6d));
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<12>(h)), hn::Set(di, 0x297a2d39));
  h = hn::And(hn::ShiftRight<8>(h), hn::Set(di, 0xffff));
  return hn::MulAdd(hn::ConvertTo(df, h), F(2.0f / 65535), F(-1));
}

// Smooth between the corners of a lattice of the width 1; -1 to 1.
HWY_INLINE VF Noise(VF x, VF y) {
  const VF xf = hn::Floor(x), yf = hn::Floor(y);
  const VI corner = hn::Add(hn::Mul(hn::ConvertTo(di, xf), hn::Set(di, kColumn)),
                            hn::Mul(hn::ConvertTo(di, yf), hn::Set(di, kRow)));
  const VI right = hn::Set(di, kColumn), above = hn::Set(di, kRow);
  const auto smooth = [](VF t) { return hn::Mul(hn::Mul(t, t), hn::NegMulAdd(F(2), t, F(3))); };
  const VF u = smooth(hn::Sub(x, xf)), v = smooth(hn::Sub(y, yf));
  const auto mix = [](VF a, VF b, VF share) { return hn::MulAdd(share, hn::Sub(b, a), a); };
  const VI upper = hn::Add(corner, above);
  return mix(mix(Corner(corner), Corner(hn::Add(corner, right)), u),
             mix(Corner(upper), Corner(hn::Add(upper, right)), u), v);
}

// What the brightness of the ground is multiplied by. x, y: m, in the world; footprint: width of a pixel on
// it, m; growth: 0 of stone to 1 of grass.
HWY_INLINE VF Grain(VF x, VF y, VF footprint, VF growth) {
  struct Octave {
    float width_m, grass, other;
  };
  // The widest are what a picture that repeats lacks.
  constexpr Octave kOctaves[] = {{47, 0.08f, 0},         {13, 0.09f, 0.01f},    {4.3f, 0.05f, 0.02f},
                                 {1.7f, 0.06f, 0.03f},   {0.6f, 0.09f, 0.03f},  {0.21f, 0.11f, 0.03f},
                                 {0.075f, 0.14f, 0.03f}, {0.027f, 0.17f, 0.04f}};
  VF sum = F(1);
  for (const Octave& o : kOctaves) {
    // An octave fades before it is finer than a pixel.
    const VF seen =
        hn::Min(hn::Max(hn::MulAdd(footprint, F(-1.6f / o.width_m), F(1.4f)), hn::Zero(df)), F(1));
    if (hn::AllTrue(df, hn::Le(seen, hn::Zero(df)))) break;
    const VF strength = hn::Mul(seen, hn::MulAdd(growth, F(o.grass - o.other), F(o.other)));
    // Each turned against the one before, so that no lattice shows.
    const float c = o.width_m > 0.5f ? 0.86f : 0.42f, s = o.width_m > 0.5f ? 0.51f : 0.91f,
                per = 1 / o.width_m;
    const VF a = hn::MulAdd(x, F(c * per), hn::Mul(y, F(s * per)));
    const VF b = hn::MulAdd(x, F(-s * per), hn::Mul(y, F(c * per)));
    sum = hn::MulAdd(strength, Noise(a, b), sum);
  }
  return sum;
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
