// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "base/yaml/fields.h"
#include "sim/aircraft/rotor/rotor.h"

namespace kestrel::sim {

constexpr std::size_t kMaxRotors = 12;
using RotorSpeeds =
    std::array<double, kMaxRotors>;  // rad/s, 0 or more; of those that there are, in their order

// Where a vehicle file has a rotor: in B, x forward and y right, and its spin seen from above.
struct RotorPlace {
  double x_m = 0, y_m = 0;
  std::string spin = "clockwise";
};

inline void Fields(FieldVisitor& v, RotorPlace& p) {
  v(Required("x_m", "of the shaft, forward of the centre of mass"), p.x_m, -3.0, 3.0);
  v(Required("y_m", "of the shaft, to the right of the centre of mass"), p.y_m, -3.0, 3.0);
  v(Required("spin", "seen from above"), p.spin, {"clockwise", "counterclockwise"});
}

struct RotorLayout {
  std::size_t count = 0;
  std::array<Eigen::Vector3d, kMaxRotors> hubs_B;
  std::array<Spin, kMaxRotors> spins{};
};

// What a rotor can give, N, and its reaction torque over thrust, m.
struct RotorLimits {
  double thrust_n = 0, moment_m = 0;
};

// Thrusts of the rotors, N, from 0 to the limit, that give a thrust along -z of B, N, and a torque in B, N m:
// the least squares of them (pseudo-inverse). Where the rotors cannot give both, roll and pitch torque come
// first (scaled down together), then thrust, then yaw torque. The layout must be one that CannotFly lets pass.
std::array<double, kMaxRotors> MixThrusts(const RotorLayout& layout, const RotorLimits& limits, double thrust,
                                          const Eigen::Vector3d& torque_B);

// Why rotors cannot carry and turn an aircraft of this weight, N, in plain words. None: they can.
std::optional<std::string> CannotFly(const RotorLayout& layout, const RotorLimits& limits, double weight_n);

}  // namespace kestrel::sim
