// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "sim/landscape/ground.h"
#include "sim/landscape/mesh.h"

namespace kestrel::sim::landscape {

inline constexpr int kPalette = 512;  // texels to a side

// Trees and buildings, with their shadows on the ground, as one mesh in which every triangle has a colour of
// its own: one texel of the palette.
struct Scenery {
  Mesh mesh;
  std::vector<Colour> colours;  // of each face
};
Scenery MakeScenery(const LandscapeParameters& parameters, std::uint64_t seed, const Terrain& terrain,
                    const Sky& sky, const Ground& ground);

}  // namespace kestrel::sim::landscape
