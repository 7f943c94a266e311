// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/terrain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"
#include "sim/landscape/noise.h"

namespace kestrel::sim::landscape {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

float Drop(float r) { return static_cast<float>(static_cast<double>(r) * r / (2 * kEarth_m)); }

// Under the plane and its edge the mesh lies a little deeper, so that neither shines through the other.
float Sunk(float r) { return 0.1f * (1 - Step(430, 700, r)); }

// Of chains of hills, one behind the other, for a maximum slope of about 1.
float Chains(const Noise& noise, float azimuth, float r) {
  constexpr float kDistances_m[] = {1700, 4200, 10000, 24000};
  float height = 0;
  for (int k = 0; k < 4; ++k) {
    const float d = kDistances_m[k];
    const float away = std::log(r / d) / 0.30f;
    if (std::abs(away) > 3.5f) continue;
    const float turn = 2.5f + 1.5f * static_cast<float>(k);
    const float along = noise.Fractal(turn * std::cos(azimuth) + 40 * static_cast<float>(k) + 20,
                                      turn * std::sin(azimuth) + 20, 6);
    const float rough =
        noise.Fractal(r * std::cos(azimuth) / (0.25f * d), r * std::sin(azimuth) / (0.25f * d), 5);
    const float crest = std::max(0.0f, along - 0.3f) * (0.6f + 0.8f * rough);
    height = std::max(height, d * crest * std::exp(-0.5f * away * away));
  }
  return height * Step(500, 1100, r);
}

float RidgeHeight(const RidgeParameters& ridge, const Noise& noise, float azimuth, float r) {
  if (ridge.height_deg <= 0 || ridge.width_deg <= 0) return 0;
  const float d = static_cast<float>(ridge.distance_m);
  const float along = Step(0.70f * d, d, r) * (1 - Step(1.12f * d, 1.5f * d, r));
  if (along <= 0) return 0;
  const float off = std::abs(std::remainder(azimuth - static_cast<float>(Radians(ridge.azimuth_deg)), kTurn));
  const float half = static_cast<float>(Radians(ridge.width_deg / 2));
  const float across = ridge.width_deg >= 360 ? 1 : 1 - Step(half - 0.02f, half + 0.02f, off);
  const float crest = d * static_cast<float>(std::tan(Radians(ridge.height_deg))) + Drop(d);
  const float rough = noise.Fractal(12 * std::cos(azimuth) + 90, 12 * std::sin(azimuth) + 90, 5);
  return along * across * crest * (1 - 0.05f * rough);
}

}  // namespace

Terrain::Terrain(const LandscapeParameters& p, std::uint64_t seed)
    : hills_(static_cast<std::size_t>(kRings) * kSectors) {
  const Noise noise(seed, "landscape hills");
  // One scale for all hills, by which the highest just reaches its angle.
  const float slope = static_cast<float>(std::tan(Radians(p.hills_deg)));
  float scale = 1e9f;
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kSectors; ++j) {
      const float azimuth = kTurn * static_cast<float>(j) / kSectors, r = Radius(i);
      const float towards =
          0.5f + 0.5f * std::cos(azimuth - static_cast<float>(Radians(p.hills_azimuth_deg)));
      const float side = 1 - static_cast<float>(p.hills_one_sided) * (1 - Step(0.15f, 0.85f, towards));
      float& h = hills_[static_cast<std::size_t>(i) * kSectors + j];
      h = p.hills_deg > 0 ? side * Chains(noise, azimuth, r) : 0;
      if (h > 0) scale = std::min(scale, (slope * r + Drop(r)) / h);
    }
  }
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kSectors; ++j) {
      float& h = hills_[static_cast<std::size_t>(i) * kSectors + j];
      h = std::max(scale * h,
                   RidgeHeight(p.ridge, noise, kTurn * static_cast<float>(j) / kSectors, Radius(i)));
    }
  }
}

float Terrain::Radius(int ring) const {
  return kInner_m * std::pow(kOuter_m / kInner_m, static_cast<float>(ring) / (kRings - 1));
}

float Terrain::HillHeight(float north, float east) const {
  const float r = std::hypot(north, east);
  if (r <= 500) return 0;  // there is none so near
  const float ring = std::min(std::log(r / kInner_m) / std::log(kOuter_m / kInner_m) * (kRings - 1),
                              static_cast<float>(kRings) - 1.001f);
  float sector = std::atan2(east, north) / kTurn * kSectors;
  if (sector < 0) sector += kSectors;
  const int i = static_cast<int>(ring), j = static_cast<int>(sector) % kSectors, k = (j + 1) % kSectors;
  const float u = ring - static_cast<float>(i), v = sector - std::floor(sector);
  const float* low = &hills_[static_cast<std::size_t>(i) * kSectors];
  const float* high = low + kSectors;
  return (1 - u) * ((1 - v) * low[j] + v * low[k]) + u * ((1 - v) * high[j] + v * high[k]);
}

float Terrain::Height(float north, float east) const {
  const float r = std::hypot(north, east);
  return HillHeight(north, east) - (r > kInner_m ? Drop(r) + Sunk(r) : 0);
}

Eigen::Vector3f Terrain::Normal(float north, float east) const {
  const float step = std::max(4.0f, 0.02f * std::hypot(north, east));
  const float along = (HillHeight(north + step, east) - HillHeight(north - step, east)) / (2 * step);
  const float across = (HillHeight(north, east + step) - HillHeight(north, east - step)) / (2 * step);
  return Eigen::Vector3f(-along, -across, 1).normalized();
}

float Terrain::MeshHeight(int ring, int sector) const {
  const float r = Radius(ring);
  return hills_[static_cast<std::size_t>(ring) * kSectors + sector % kSectors] - Drop(r) - Sunk(r);
}

std::vector<int> Terrain::KeptRings() const {
  constexpr int kMostAtOnce = 4;
  // Whether those between two rings are as if drawn from one to the other.
  const auto straight = [&](int from, int to) {
    for (int i = from + 1; i < to; ++i) {
      const float share = (Radius(i) - Radius(from)) / (Radius(to) - Radius(from));
      for (int j = 0; j < kSectors; ++j) {
        const float drawn = std::lerp(MeshHeight(from, j), MeshHeight(to, j), share);
        if (std::abs(MeshHeight(i, j) - drawn) > kUnseen_rad * Radius(i)) return false;
      }
    }
    return true;
  };
  std::vector<int> kept{0};
  while (kept.back() + 1 < kRings) {
    int next = kept.back() + 1;
    while (next + 1 < kRings && next - kept.back() < kMostAtOnce && straight(kept.back(), next + 1)) ++next;
    kept.push_back(next);
  }
  return kept;
}

std::vector<int> Terrain::KeptSectors(int ring) const {
  constexpr int kMostAtOnce = 8;
  std::vector<int> kept;
  // Those from one sector on and before another. (Douglas and Peucker, 1973.)
  const auto keep = [&](const auto& self, int from, int to) -> void {
    int farthest = (from + to) / 2;
    float most = 0;
    for (int j = from + 1; j < to; ++j) {
      const float share = static_cast<float>(j - from) / static_cast<float>(to - from);
      const float drawn = std::lerp(MeshHeight(ring, from), MeshHeight(ring, to), share);
      const float off = std::abs(MeshHeight(ring, j) - drawn);
      if (off > most) most = off, farthest = j;
    }
    const bool seen = most > kUnseen_rad * Radius(ring);
    if (!seen && to - from <= kMostAtOnce) return kept.push_back(from);
    if (!seen) farthest = (from + to) / 2;
    self(self, from, farthest);
    self(self, farthest, to);
  };
  keep(keep, 0, kSectors);
  kept.push_back(kSectors);
  return kept;
}

Mesh Terrain::ToMesh() const {
  Mesh mesh;
  struct Line {
    std::vector<int> sectors;
    int first;  // vertex
  };
  std::vector<Line> lines;
  for (const int i : KeptRings()) {
    lines.push_back({KeptSectors(i), static_cast<int>(mesh.vertices.size())});
    for (const int j : lines.back().sectors) {
      const float azimuth = kTurn * static_cast<float>(j) / kSectors, r = Radius(i);
      mesh.vertices.emplace_back(r * std::cos(azimuth), -r * std::sin(azimuth), MeshHeight(i, j));
      // It is drawn as painted, so its normals only tell edges from smooth ground.
      mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
      mesh.st.emplace_back(static_cast<float>(j) / kSectors, static_cast<float>(i) / (kRings - 1));
    }
  }
  for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
    // Azimuth grows clockwise as seen from above. Every line is the border of two strips, which leaves no gap.
    const Line &inner = lines[k], &outer = lines[k + 1];
    std::size_t a = 0, b = 0;
    while (a + 1 < inner.sectors.size() || b + 1 < outer.sectors.size()) {
      const int own = inner.first + static_cast<int>(a), other = outer.first + static_cast<int>(b);
      const bool at_end = a + 1 == inner.sectors.size();
      if (at_end || (b + 1 < outer.sectors.size() && outer.sectors[b + 1] <= inner.sectors[a + 1])) {
        mesh.faces.emplace_back(own, other + 1, other);
        ++b;
      } else {
        mesh.faces.emplace_back(own, own + 1, other);
        ++a;
      }
    }
  }
  return mesh;
}

}  // namespace kestrel::sim::landscape
