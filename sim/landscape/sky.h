// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "sim/landscape/landscape.h"
#include "sim/landscape/noise.h"

namespace kestrel::sim::landscape {

using Colour = Eigen::Vector3f;  // red, green, blue; 1: as bright as the image can show

inline Colour Mixed(const Colour& a, const Colour& b, float share) { return a + share * (b - a); }

// What is seen in every direction of the sky, and the light that falls from it. Directions and places in N' :
// north, east, up.
class Sky {
 public:
  Sky(const LandscapeParameters& parameters, std::uint64_t seed);

  Colour At(const Eigen::Vector3f& direction) const;  // unit; below the horizontal: as at the horizontal
  Colour Haze(float azimuth) const;                   // what far ground fades into
  // Of a surface with that colour and normal at that place, as seen from near the origin.
  Colour Lit(const Colour& albedo, const Eigen::Vector3f& normal, float north, float east) const;
  Colour Hazed(const Colour& colour, float distance_m, float azimuth) const;
  Colour LevelLight() const;  // on level ground without clouds' shadows

  const Eigen::Vector3f& sun() const { return sun_; }  // direction to it

 private:
  float Cloud(float north_m, float east_m, int octaves) const;  // 0 to 1
  float Density(float noise) const;
  Colour WithBands(const Colour& colour, float elevation, float azimuth) const;

  LandscapeParameters p_;
  Noise clouds_, bands_;
  Eigen::Vector3f sun_;
  Colour glow_, sunlight_, ambient_, zenith_, horizon_, sunward_, bright_, dark_;
  float threshold_ = 0, open_ = 1;
  std::uint64_t salt_;  // of the bands
};

}  // namespace kestrel::sim::landscape
