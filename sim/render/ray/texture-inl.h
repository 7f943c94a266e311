// SPDX-License-Identifier: Apache-2.0
// Colours from pyramids of texels.
// Included once for each instruction set.
#if defined(KESTREL_SIM_RAY_TEXTURE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KESTREL_SIM_RAY_TEXTURE_INL_H_
#undef KESTREL_SIM_RAY_TEXTURE_INL_H_
#else
#define KESTREL_SIM_RAY_TEXTURE_INL_H_
#endif

#include <bit>
#include <cstring>

#include "sim/render/pyramid/pyramid.h"
#include "sim/render/ray/packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

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

// Which texels a packet mixes: planned with all lanes at once, fetched one by one. The two are apart so that
// the processor can plan for one packet while it waits for the texels of others.
struct Fetch {
  Taps taps;
  const Pyramid* picture = nullptr;  // null: no texture
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
  fetch.picture = &p;
}

// Eight bytes, which have two texels, from each of two places, for so many pixels: one block of 16 bytes each. Places
// in bytes.
template <int blocks>
HWY_INLINE auto Blocks(const std::uint8_t* texels, const std::int32_t* above, const std::int32_t* below) {
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

// Mixes the four texels of each lane: mixed + 4 lane is blue, green, red, 0, times kWeightScale. Every lane
// has a place in the picture, wanted or not. A block of 16 bytes holds the upper and the lower two texels of
// one lane.
template <class Texel>
HWY_INLINE void MixOf(const Texel* texels_of, const Taps& taps, std::int32_t* mixed) {
  const hn::Repartition<std::uint8_t, DF> d8;
  const hn::Repartition<std::int16_t, DF> d16;
  constexpr int kBlocks = kLanes / 4;
  // Of two texels side by side, channel by channel, 16 bits each: b b' g g' r r' 0 0.
  alignas(16) static constexpr std::uint8_t kOfColours[16] = {0, 0x80, 3, 0x80, 1,    0x80, 4,    0x80,
                                                              2, 0x80, 5, 0x80, 0x80, 0x80, 0x80, 0x80};
  alignas(16) static constexpr std::uint8_t kOfGreys[16] = {0, 0x80, 1, 0x80, 0,    0x80, 1,    0x80,
                                                            0, 0x80, 1, 0x80, 0x80, 0x80, 0x80, 0x80};
  const auto upper = hn::LoadDup128(d8, sizeof(Texel) == 1 ? kOfGreys : kOfColours);
  const auto lower = hn::Or(upper, hn::Set(d8, 8));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(texels_of);
  const VI size = hn::Set(di, sizeof(Texel));
  alignas(64) std::int32_t above[kLanes], below[kLanes];
  hn::Store(hn::Mul(hn::Load(di, taps.offset), size), di, above);
  hn::Store(hn::Mul(hn::Load(di, taps.below), size), di, below);
  const VI upper_weights = hn::Load(di, taps.upper), lower_weights = hn::Load(di, taps.lower);
  for (int i = 0; i < kLanes; i += kBlocks) {
    const auto texels = hn::BitCast(d8, Blocks<kBlocks>(bytes, above + i, below + i));
    // The weights of a lane over all of its block.
    const auto lanes = hn::IndicesFromVec(di, hn::Add(hn::Set(di, i), hn::ShiftRight<2>(hn::Iota(di, 0))));
    const auto weights = [&](VI of) { return hn::BitCast(d16, hn::TableLookupLanes(of, lanes)); };
    auto none = hn::Zero(di);
    const VI sum = hn::ReorderWidenMulAccumulate(di, hn::BitCast(d16, hn::TableLookupBytesOr0(texels, upper)),
                                                 weights(upper_weights), hn::Zero(di), none);
    hn::Store(hn::ReorderWidenMulAccumulate(di, hn::BitCast(d16, hn::TableLookupBytesOr0(texels, lower)),
                                            weights(lower_weights), sum, none),
              di, mixed + 4 * i);
  }
}

HWY_INLINE void Mix(const Fetch& fetch, std::int32_t* mixed) {
  const Pyramid& p = *fetch.picture;
  if (p.texels.empty()) return MixOf(p.grey_texels.data(), fetch.taps, mixed);
  MixOf(p.texels.data(), fetch.taps, mixed);
}

HWY_INLINE Colours Unpack(const std::int32_t* mixed) {
  VI b, g, r, unused;
  hn::LoadInterleaved4(di, mixed, b, g, r, unused);
  const VF scale = F(1 / kWeightScale);
  return {hn::Mul(hn::ConvertTo(df, r), scale), hn::Mul(hn::ConvertTo(df, g), scale),
          hn::Mul(hn::ConvertTo(df, b), scale)};
}

// By the mean of the squares of the sides of a pixel's footprint, in texels: by the longer one, what is seen aslant is
// blurred. Somewhat smaller, since the texels are interpolated besides. Both as they come nearest to the mean over
// many rays a pixel.
HWY_INLINE VF Footprint2(const Pyramid& p, VF s_u, VF t_u, VF s_v, VF t_v) {
  const VF w = F(p.width[0]), h = F(p.height[0]);
  const VF a = hn::Mul(s_u, w), b = hn::Mul(t_u, h), c = hn::Mul(s_v, w), d = hn::Mul(t_v, h);
  return hn::Mul(F(0.4f), hn::MulAdd(a, a, hn::MulAdd(b, b, hn::MulAdd(c, c, hn::Mul(d, d)))));
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

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
