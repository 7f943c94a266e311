// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/sky_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/render/ray/instruction_targets.h"  // before Highway
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/render/ray/sky_light.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "sim/render/ray/grass-inl.h"
#include "sim/render/ray/surface-inl.h"
#include "sim/render/ray/trace-inl.h"

#ifndef KESTREL_SIM_RAY_SKY_LIGHT_ONCE
#define KESTREL_SIM_RAY_SKY_LIGHT_ONCE
namespace kestrel::sim::ray {

inline constexpr int kRays = 6;       // to the sun, and as many to the sky; four neighbours share theirs
inline constexpr int kTurns = 4;      // a pixel and its neighbours have different ones
inline constexpr float kReach_m = 4;  // what is farther hides nothing of the sky
inline constexpr float kEnd_m = 400;  // farther off all is as it was

// Directions about the z axis, in fixed places: of the cosine's distribution over the hemisphere, and evenly over a
// disc of radius 1.
struct Places {
  float sky[kRays][3][kTurns], sun[kRays][2][kTurns];
  Places() {
    for (int i = 0; i < kRays; ++i) {
      for (int turn = 0; turn < kTurns; ++turn) {
        const double share = (i + (turn + 0.5) / kTurns) / kRays, radius = std::sqrt(share);
        const double angle = (i + turn * 0.25) * std::numbers::pi * (3 - std::sqrt(5.0)) + turn * 0.7;
        const double x = radius * std::cos(angle), y = radius * std::sin(angle);
        sky[i][0][turn] = static_cast<float>(x), sky[i][1][turn] = static_cast<float>(y);
        sky[i][2][turn] = static_cast<float>(std::sqrt(std::max(0.0, 1 - share)));
        sun[i][0][turn] = static_cast<float>(x), sun[i][1][turn] = static_cast<float>(y);
      }
    }
  }
};

inline const Places& ThePlaces() {
  static const Places places;
  return places;
}

// The strongest parallel light of the model; -1: there is none.
inline int SunOf(const RenderScene& scene) {
  int sun = -1;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const ray::Light& light = scene.lights[i];
    if (!light.directional || light.id < 0 || light.diffuse.sum() <= 0) continue;
    if (sun < 0 || light.diffuse.sum() > scene.lights[static_cast<std::size_t>(sun)].diffuse.sum())
      sun = static_cast<int>(i);
  }
  return sun;
}

struct Ball {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  float radius = -1;  // none
};

inline Ball BallOf(const GeomInstance& placed, const Geom& thing) {
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> R_GC(placed.R);
  return {placed.distance * Eigen::Map<const Eigen::Vector3f>(placed.towards) +
              R_GC.transpose() * thing.box_centre,
          thing.box_half.norm()};
}

}  // namespace kestrel::sim::ray
#endif

HWY_BEFORE_NAMESPACE();
namespace kestrel::sim::ray::HWY_NAMESPACE {
namespace {

// What may stand in the way of light to the points of a ball.
struct Near {
  std::vector<int> sun, sky;
};

// The sun as it stands in C.
struct Sun {
  bool shines = false;
  Eigen::Vector3f towards = Eigen::Vector3f::UnitZ(), across = Eigen::Vector3f::UnitX(),
                  down = Eigen::Vector3f::UnitY();
  float radius = 0;  // tangent of the angle that it is seen under
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
};

Sun MakeSun(const Slice& slice) {
  Sun sun;
  const int index = SunOf(*slice.things);
  if (index < 0) return sun;
  const ray::Light& light = slice.things->lights[static_cast<std::size_t>(index)];
  sun.shines = true;
  sun.towards =
      -Eigen::Map<const Eigen::Vector3f>(slice.placement->lights[static_cast<std::size_t>(index)].direction)
           .normalized();
  sun.across = sun.towards.unitOrthogonal();
  sun.down = sun.towards.cross(sun.across);
  // Lamps that cast no shadows of their own are many, and wide.
  sun.radius = light.shadows ? 0.007f : 0.25f;
  sun.colour = light.diffuse;
  return sun;
}

// Whether some part of a large mesh is near the ball.
bool PartsNear(const Geom& thing, const GeomInstance& placed, const Eigen::Vector3f& centre_C, float reach) {
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> R_GC(placed.R);
  const Eigen::Vector3f centre = R_GC * centre_C + Eigen::Map<const Eigen::Vector3f>(placed.o);
  const std::vector<Triangles::Part>& parts = thing.triangles->parts;
  for (std::size_t i = 0; i < parts.size();) {
    const Eigen::Vector3f off = ((centre - parts[i].centre).cwiseAbs() - parts[i].half).cwiseMax(0.0f);
    const bool here = off.squaredNorm() <= reach * reach;
    if (here && parts[i].next == i + 1) return true;
    i = here ? i + 1 : parts[i].next;
  }
  return false;
}

// Of `from` what is near the points.
void FindNear(const Slice& slice, const std::vector<Ball>& balls, const Sun& sun, const Ball& points,
              const Near& from, Near& to) {
  to.sun.clear(), to.sky.clear();
  for (const int i : from.sky) {
    const float reach = kReach_m + points.radius;
    if ((balls[static_cast<std::size_t>(i)].centre - points.centre).norm() >
        reach + balls[static_cast<std::size_t>(i)].radius)
      continue;
    const Geom& thing = slice.things->all[static_cast<std::size_t>(i)];
    if (thing.triangles &&
        !PartsNear(thing, slice.placement->things[static_cast<std::size_t>(i)], points.centre, reach))
      continue;
    to.sky.push_back(i);
  }
  if (!sun.shines) return;
  for (const int i : from.sun) {
    const Ball& ball = balls[static_cast<std::size_t>(i)];
    const Eigen::Vector3f off = ball.centre - points.centre;
    const float along = off.dot(sun.towards), reach = ball.radius + points.radius;
    if (along < -reach) continue;
    const float widest = reach + sun.radius * std::max(0.0f, along + reach);
    if (off.squaredNorm() - along * along > widest * widest) continue;
    to.sun.push_back(i);
  }
}

Ball BallAround(const Vec3& p, MF wanted) {
  Ball ball;
  if (hn::AllFalse(df, wanted)) return ball;
  const auto least = [&](VF v) {
    return hn::GetLane(hn::MinOfLanes(df, hn::IfThenElse(wanted, v, F(1e9f))));
  };
  const auto most = [&](VF v) {
    return hn::GetLane(hn::MaxOfLanes(df, hn::IfThenElse(wanted, v, F(-1e9f))));
  };
  const Eigen::Vector3f low(least(p.x), least(p.y), least(p.z)), high(most(p.x), most(p.y), most(p.z));
  ball.centre = 0.5f * (low + high);
  ball.radius = 0.5f * (high - low).norm() + 1e-3f;
  return ball;
}

Ball Joined(const Ball& a, const Ball& b) {
  if (a.radius < 0) return b;
  if (b.radius < 0) return a;
  const float apart = (b.centre - a.centre).norm();
  if (apart + b.radius <= a.radius) return a;
  if (apart + a.radius <= b.radius) return b;
  const float radius = 0.5f * (apart + a.radius + b.radius);
  return {a.centre + (radius - a.radius) / apart * (b.centre - a.centre), radius};
}

// A packet of pixels and what their rays meet.
struct alignas(64) Packet {
  MF wanted;     // what light is changed on
  Vec3 d, p, n;  // p: just above the surface
  VF glow;       // of the surface itself
  VF baked;      // 1: its light is painted in
  VF sheet;      // 1: ground
  VI thing;
  VF sun, sky;  // the shares of them that are seen
  Ball ball;
};

// Fills the packet but for its ball.
void Meet(const Slice& slice, const Seen& seen, int v, std::ptrdiff_t at, Packet& packet) {
  const Rays rays = RaysAt(*slice.lens, at);
  packet.d = rays.d;
  TriangleHits triangles;
  Hit hit = Trace(slice, seen, OneRow(v), rays.d, triangles);
  EndPlane(slice, rays.d, hit);
  packet.wanted = hn::And(InsideAt(*slice.lens, at), hn::Lt(hit.t, F(kEnd_m)));
  const VF zero = hn::Zero(df);
  packet.glow = packet.baked = packet.sheet = zero;
  packet.n = {zero, zero, zero};
  packet.thing = hit.thing;
  alignas(64) std::int32_t index[kLanes];
  hn::Store(hit.thing, di, index);
  const VF t = hn::IfThenElse(packet.wanted, hit.t, F(1));
  for (MF left = packet.wanted; !hn::AllFalse(df, left);) {
    const int i = index[hn::FindFirstTrue(df, left)];
    const MF here = hn::And(left, hn::RebindMask(df, hn::Eq(hit.thing, hn::Set(di, i))));
    left = hn::AndNot(here, left);
    const Geom& thing = slice.things->all[static_cast<std::size_t>(i)];
    if (thing.emission >= 1 && !thing.baked) {  // a lamp
      packet.wanted = hn::AndNot(here, packet.wanted);
      continue;
    }
    const GeomInstance& placed = slice.placement->things[static_cast<std::size_t>(i)];
    Vec3 n;
    VI side;
    NormalOf(thing, Along(Load3(placed.o), t, Rotate(placed.R, rays.d)), triangles, here, n, side);
    n = RotateBack(placed.R, n);
    packet.n = {hn::IfThenElse(here, n.x, packet.n.x), hn::IfThenElse(here, n.y, packet.n.y),
                hn::IfThenElse(here, n.z, packet.n.z)};
    packet.glow = hn::IfThenElse(here, F(thing.baked ? 0.0f : thing.emission), packet.glow);
    packet.baked = hn::IfThenElse(here, F(thing.baked ? 1.0f : 0.0f), packet.baked);
    packet.sheet = hn::IfThenElse(here, F(thing.sheet ? 1.0f : 0.0f), packet.sheet);
  }
  packet.p = Scale(rays.d, t);
  // From just above the surface, by what rounding may do at that distance.
  packet.p = Along(packet.p, hn::MulAdd(t, F(2e-5f), F(5e-4f)), packet.n);
}

// A table's values, by the pixel's place among its neighbours.
HWY_INLINE VF Turned(const float (&of)[kTurns], int v) {
  alignas(64) float lanes[kLanes];
  for (int i = 0; i < kLanes; ++i) lanes[i] = of[(i & 1) + 2 * (v & 1)];
  return hn::Load(df, lanes);
}

// Of light from the point along d, by what it meets first: its distance.
HWY_INLINE VF Meets(const Slice& slice, int i, const Vec3& p, const Vec3& d, VF reach) {
  const Geom& thing = slice.things->all[static_cast<std::size_t>(i)];
  const GeomInstance& placed = slice.placement->things[static_cast<std::size_t>(i)];
  TriangleHits unused;
  return Enter(thing, thing.size, Rotate(placed.R, p) + Load3(placed.o), Rotate(placed.R, d), reach, unused);
}

// Which rays from p along d come near the ball: what is in it no others meet.
HWY_INLINE MF Passes(const Ball& ball, const Vec3& p, const Vec3& d) {
  const Vec3 to = Load3(ball.centre.data()) - p;
  const Vec3 across{hn::MulSub(to.y, d.z, hn::Mul(to.z, d.y)), hn::MulSub(to.z, d.x, hn::Mul(to.x, d.z)),
                    hn::MulSub(to.x, d.y, hn::Mul(to.y, d.x))};
  const float radius = 1.001f * ball.radius + 1e-3f;
  return hn::Le(Dot(across, across), hn::Mul(Dot(d, d), F(radius * radius)));
}

// The share of the sun that is seen.
VF SunSeen(const Slice& slice, const Sun& sun, const std::vector<Ball>& balls, const Near& near,
           const Packet& packet, int v) {
  if (near.sun.empty()) return F(1);
  const Places& places = ThePlaces();
  VF sum = hn::Zero(df);
  for (int k = 0; k < kRays; ++k) {
    const VF a = hn::Mul(Turned(places.sun[k][0], v), F(sun.radius)),
             b = hn::Mul(Turned(places.sun[k][1], v), F(sun.radius));
    const Vec3 d =
        Along(Along(Load3(sun.towards.data()), a, Load3(sun.across.data())), b, Load3(sun.down.data()));
    VF through = F(1);
    for (const int i : near.sun) {
      if (hn::AllFalse(df, Passes(balls[static_cast<std::size_t>(i)], packet.p, d))) continue;
      const MF met = hn::Lt(Meets(slice, i, packet.p, d, F(kFar)), F(kFar));
      const GeomInstance& placed = slice.placement->things[static_cast<std::size_t>(i)];
      through =
          hn::IfThenElse(met, hn::Mul(through, F(placed.transparent ? 1 - placed.alpha : 0.0f)), through);
      if (hn::AllTrue(df, hn::Or(hn::Eq(through, hn::Zero(df)), hn::Not(packet.wanted)))) break;
    }
    sum = hn::Add(sum, through);
  }
  return hn::Mul(sum, F(1.0f / kRays));
}

// The share of the sky that is seen from the surface, by the cosine.
VF SkySeen(const Slice& slice, const std::vector<Ball>& balls, const Near& near, const Packet& packet,
           int v) {
  if (near.sky.empty()) return F(1);
  const Places& places = ThePlaces();
  // Two directions along the surface (Duff et al. 2017).
  const Vec3& n = packet.n;
  const VF sign = hn::CopySign(F(1), n.z), a = hn::Div(F(-1), hn::Add(sign, n.z)),
           b = hn::Mul(hn::Mul(n.x, n.y), a);
  const Vec3 e1{hn::MulAdd(hn::Mul(sign, a), hn::Mul(n.x, n.x), F(1)), hn::Mul(sign, b),
                hn::Neg(hn::Mul(sign, n.x))};
  const Vec3 e2{b, hn::MulAdd(a, hn::Mul(n.y, n.y), sign), hn::Neg(n.y)};
  VF hidden = hn::Zero(df);
  for (int k = 0; k < kRays; ++k) {
    const Vec3 d = Along(Along(Scale(n, Turned(places.sky[k][2], v)), Turned(places.sky[k][0], v), e1),
                         Turned(places.sky[k][1], v), e2);
    VF nearest = F(kReach_m);
    for (const int i : near.sky)
      if (!hn::AllFalse(df, Passes(balls[static_cast<std::size_t>(i)], packet.p, d)))
        nearest = hn::Min(nearest, Meets(slice, i, packet.p, d, nearest));
    const VF close = hn::NegMulAdd(nearest, F(1 / kReach_m), F(1));
    hidden = hn::MulAdd(close, close, hidden);
  }
  return hn::NegMulAdd(hidden, F(1.0f / kRays), F(1));
}

// Four pixels that lie together have looked at different places of sun and sky: what they have in common.
void ShareLight(Packet& upper, Packet& lower) {
  const auto beside = [](VF v) { return hn::Shuffle2301(v); };
  const auto turned = [&](const Packet& of) {
    Packet p = of;
    p.n = {beside(of.n.x), beside(of.n.y), beside(of.n.z)};
    p.thing = hn::Shuffle2301(of.thing);
    p.sun = beside(of.sun), p.sky = beside(of.sky);
    return p;
  };
  const Packet all[4] = {upper, turned(upper), lower, turned(lower)};
  const auto mean = [&](const Packet& own, Packet& to) {
    VF count = hn::Zero(df), sun = count, sky = count;
    for (const Packet& other : all) {
      const MF same =
          hn::And(hn::RebindMask(df, hn::Eq(own.thing, other.thing)), hn::Gt(Dot(own.n, other.n), F(0.8f)));
      count = hn::Add(count, hn::IfThenElseZero(same, F(1)));
      sun = hn::Add(sun, hn::IfThenElseZero(same, other.sun));
      sky = hn::Add(sky, hn::IfThenElseZero(same, other.sky));
    }
    const MF some = hn::Gt(count, hn::Zero(df));
    to.sun = hn::IfThenElse(some, hn::Div(sun, count), own.sun);
    to.sky = hn::IfThenElse(some, hn::Div(sky, count), own.sky);
  };
  mean(all[0], upper);
  mean(all[2], lower);
}

// What the drawn colours are multiplied by.
Colours Relight(const Slice& slice, const Sun& sun, const Packet& packet) {
  const VF one = F(1), zero = hn::Zero(df);
  const Vec3 up = Load3(slice.placement->R_MC + 6);
  // From below comes what the ground throws back; painted light has that in it.
  const VF above =
      hn::MulAdd(hn::MulAdd(Dot(packet.n, up), F(0.2f), F(-0.2f)), hn::Sub(one, packet.baked), one);
  const VF cosine = hn::Max(Dot(packet.n, Load3(sun.towards.data())), zero);
  const VF sky = hn::Mul(above, packet.sky), direct = hn::Mul(cosine, packet.sun);
  Eigen::Vector3f ambient = Eigen::Vector3f::Zero();
  for (const ray::Light& light : slice.things->lights) ambient += light.ambient;
  const auto channel = [&](int c) {
    const VF now = hn::MulAdd(F(ambient[c]), sky, hn::MulAdd(F(sun.colour[c]), direct, packet.glow));
    const VF before = hn::MulAdd(F(sun.colour[c]), cosine, hn::Add(F(ambient[c]), packet.glow));
    return hn::Div(now, hn::Max(before, F(1e-4f)));
  };
  return {channel(0), channel(1), channel(2)};
}

// How much like plants and soil a colour is, and not like stone or water, 0 to 1.
HWY_INLINE VF Growth(const Colours& c) {
  const VF most = hn::Max(hn::Max(c.r, c.g), F(1)), least = hn::Min(c.b, hn::Min(c.r, c.g));
  const VF pure = hn::Div(hn::Sub(most, least), most);
  return hn::IfThenElseZero(hn::Lt(c.b, c.g),
                            hn::Min(hn::Max(hn::MulAdd(pure, F(4), F(-0.5f)), hn::Zero(df)), F(1)));
}

void Apply(const Slice& slice, const Packet& packet, const Colours& light, const Canvas& canvas, int v,
           int u) {
  const int pixels = std::min(kLanes, slice.lens->width - u);
  alignas(64) float c[3][kLanes] = {};
  std::uint8_t* const bgr =
      canvas.bgr ? canvas.bgr + v * canvas.step + 3 * static_cast<std::size_t>(u) : nullptr;
  float* const grey = canvas.grey ? canvas.grey + v * canvas.step + u : nullptr;
  for (int i = 0; i < pixels; ++i)
    for (int k = 0; k < 3; ++k) c[k][i] = bgr ? static_cast<float>(bgr[3 * i + k]) : grey[i];
  Colours colour{hn::Load(df, c[2]), hn::Load(df, c[1]), hn::Load(df, c[0])};
  VF grain = F(1);
  const MF ground = hn::And(packet.wanted, hn::Gt(packet.sheet, F(0.5f)));
  if (!hn::AllFalse(df, ground)) {
    const Vec3 p_M = Rotate(slice.placement->R_MC, packet.p) + Load3(slice.placement->eye_M);
    const VF distance = LengthOf(packet.p),
             slope = hn::Max(hn::Abs(hn::Div(Dot(packet.n, packet.p), distance)), F(0.02f));
    const VF footprint = hn::Div(hn::Mul(distance, F(slice.lens->pixel_rad)), hn::Sqrt(slope));
    grain = hn::IfThenElse(ground, Grain(p_M.x, p_M.y, footprint, Growth(colour)), grain);
  }
  // Nothing changes suddenly at the end.
  const VF near = hn::Min(hn::Max(hn::MulAdd(LengthOf(packet.p), F(-4 / kEnd_m), F(4)), hn::Zero(df)), F(1));
  const auto changed = [&](VF value, VF by) {
    const VF whole = hn::MulAdd(near, hn::MulSub(by, grain, F(1)), F(1));
    return hn::IfThenElse(packet.wanted, hn::Min(hn::Mul(value, whole), F(255)), value);
  };
  const auto store = [&](VF value, int k) { hn::Store(value, df, c[k]); };
  store(changed(colour.b, light.b), 0), store(changed(colour.g, light.g), 1),
      store(changed(colour.r, light.r), 2);
  if (grey) {
    for (int i = 0; i < pixels; ++i) grey[i] = 0.114f * c[0][i] + 0.587f * c[1][i] + 0.299f * c[2][i];
    return;
  }
  for (int i = 0; i < pixels; ++i)
    for (int k = 0; k < 3; ++k) bgr[3 * i + k] = static_cast<std::uint8_t>(c[k][i] + 0.5f);
}

void LightRowsImpl(const Slice& slice, int begin, int end, const Canvas& canvas) {
  if (!slice.things->lit) return;
  const Lens& lens = *slice.lens;
  const int tile_row = begin / Lens::kTile;
  constexpr int kPackets = Lens::kTile / kLanes;
  static thread_local std::vector<Packet> packets;
  static thread_local Seen seen;
  static thread_local std::vector<Ball> balls;
  static thread_local Near all, of_tile, of_packet;
  balls.resize(slice.things->all.size());
  all.sun.clear();
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Geom& thing = slice.things->all[i];
    balls[i] = BallOf(slice.placement->things[i], thing);
    if (!thing.sheet) all.sun.push_back(static_cast<int>(i));
  }
  all.sky.clear();
  for (const int i : all.sun)
    if (!slice.placement->things[static_cast<std::size_t>(i)].transparent) all.sky.push_back(i);
  const Sun sun = MakeSun(slice);
  packets.resize(static_cast<std::size_t>((end - begin) * kPackets));
  for (int column = 0; column < lens.tiles_x; ++column) {
    if (lens.reach[tile_row * lens.tiles_x + column] < 0) continue;
    ListSeen(slice, column, seen);
    if (seen.opaque.empty() && seen.triangles->all.empty()) continue;
    const int u0 = column * Lens::kTile;
    Ball tile;
    for (int v = begin; v < end; ++v) {
      for (int k = 0; k < kPackets; ++k) {
        Packet& packet = packets[static_cast<std::size_t>((v - begin) * kPackets + k)];
        packet.ball = {};
        if (u0 + k * kLanes >= lens.width) continue;
        Meet(slice, seen, v, static_cast<std::ptrdiff_t>(v) * lens.stride + u0 + k * kLanes, packet);
        packet.ball = BallAround(packet.p, packet.wanted);
        tile = Joined(tile, packet.ball);
      }
    }
    if (tile.radius < 0) continue;
    FindNear(slice, balls, sun, tile, all, of_tile);
    const auto at = [&](int v, int k) -> Packet& {
      return packets[static_cast<std::size_t>((v - begin) * kPackets + k)];
    };
    for (int v = begin; v < end; ++v) {
      for (int k = 0; k < kPackets; ++k) {
        Packet& packet = at(v, k);
        packet.sun = packet.sky = F(1);
        if (packet.ball.radius < 0) continue;
        FindNear(slice, balls, sun, packet.ball, of_tile, of_packet);
        packet.sun = SunSeen(slice, sun, balls, of_packet, packet, v);
        packet.sky = SkySeen(slice, balls, of_packet, packet, v);
      }
    }
    for (int v = begin; v < end; ++v) {
      for (int k = 0; k < kPackets; ++k) {
        Packet& packet = at(v, k);
        if (packet.ball.radius < 0) continue;
        if (v % 2 == 0 || v == begin)
          ShareLight(packet, v + 1 < end && at(v + 1, k).ball.radius >= 0 ? at(v + 1, k) : packet);
        Apply(slice, packet, Relight(slice, sun, packet), canvas, v, u0 + k * kLanes);
      }
    }
  }
}

}  // namespace
}  // namespace kestrel::sim::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kestrel::sim::ray {

HWY_EXPORT(LightRowsImpl);
void LightRows(const Slice& slice, int begin, int end, const Canvas& canvas) {
  HWY_DYNAMIC_DISPATCH(LightRowsImpl)(slice, begin, end, canvas);
}

}  // namespace kestrel::sim::ray
#endif
