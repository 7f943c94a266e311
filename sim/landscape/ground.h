// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "sim/landscape/sky.h"
#include "sim/landscape/terrain.h"

namespace kestrel::sim::landscape {

// What grows and lies on the ground: fields with paths between, woods, water, snow. The terrain and the sky
// must outlive it.
class Ground {
 public:
  Ground(const LandscapeParameters& parameters, std::uint64_t seed, const Terrain& terrain, const Sky& sky);

  bool IsWater(float north, float east) const;
  // As seen from near the origin: lit and in haze. texel_m: finer detail than that is left out.
  Colour At(float north, float east, float texel_m) const;

 private:
  Colour Albedo(float north, float east, float texel_m) const;
  Colour Waves(float north, float east, float texel_m) const;

  LandscapeParameters p_;
  std::uint64_t salt_;
  const Terrain& terrain_;
  const Sky& sky_;
  Noise detail_, woods_, lakes_, drifts_, waves_;
  Colour grass_, crop_, soil_, forest_;
  float forest_above_, water_above_, snow_above_;
};

}  // namespace kestrel::sim::landscape
