// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/landscape/landscape.h"
#include "sim/landscape/mesh.h"

namespace kestrel::sim::landscape {

inline constexpr float kPlaneHalf_m = 300;  // of the flat ground round the origin
inline constexpr float kInner_m = 290, kOuter_m = 120e3f;

// The round ground with its hills beyond the plane, on rings that grow with the distance.
class Terrain {
 public:
  Terrain(const LandscapeParameters& parameters, std::uint64_t seed);

  // Above the plane of the origin, m; of hills alone: without the Earth's roundness.
  float Height(float north, float east) const;
  float HillHeight(float north, float east) const;
  Eigen::Vector3f Normal(float north, float east) const;  // north, east, up
  // s: azimuth from 0 to 1; t: the logarithm of the distance, 0 at kInner_m, 1 at kOuter_m. As seen from the origin,
  // about which flights are flown, no point is off by more than 1 mrad in elevation: half a pixel where 640 see 73
  // degrees.
  Mesh ToMesh() const;

 private:
  static constexpr int kRings = 96, kSectors = 360;
  static constexpr float kUnseen_rad = 5e-4f;  // along rings, and across them
  float Radius(int ring) const;
  float MeshHeight(int ring, int sector) const;
  std::vector<int> KeptRings() const;
  std::vector<int> KeptSectors(int ring) const;  // from 0 to kSectors

  std::vector<float> hills_;  // ring after ring
};

}  // namespace kestrel::sim::landscape
