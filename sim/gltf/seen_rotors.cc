// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/scene_glb.h"

namespace kestrel::sim {
namespace {

// Spin is told as seen from above, along +z of B: clockwise there is a right-hand turn about z, and so a left-hand one about
// the shaft, which points up.
int AboutShaft(Spin spin) { return -static_cast<int>(spin); }

std::vector<SeenRotor> Of(const MultirotorParameters& p) {
  std::vector<SeenRotor> rotors;
  const RotorLayout layout = LayoutOf(p);
  for (std::size_t i = 0; i < layout.count; ++i)
    rotors.push_back(
        {layout.hubs_B[i], -Eigen::Vector3d::UnitZ(), p.rotor.radius_m, AboutShaft(layout.spins[i])});
  return rotors;
}

std::vector<SeenRotor> Of(const HelicopterParameters& p) {
  return {{{0, 0, -p.rotor_height_m}, -Eigen::Vector3d::UnitZ(), p.rotor.radius_m, AboutShaft(SpinOf(p))},
          {{-p.tail_arm_m, 0, -p.tail_height_m}, -Eigen::Vector3d::UnitY(), p.tail_rotor.radius_m, 1}};
}

}  // namespace

std::vector<SeenRotor> SeenRotors(const AirframeParameters& parameters) {
  return std::visit([](const auto& p) { return Of(p); }, parameters);
}

}  // namespace kestrel::sim
