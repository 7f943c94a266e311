// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor_layout.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel::sim {
namespace {

using Mix = Eigen::Matrix<double, Eigen::Dynamic, 4, 0, static_cast<int>(kMaxRotors), 4>;

// Thrust, roll, pitch and yaw torque for each newton of each rotor, a row for each rotor. The lift of each tips the
// aircraft away from its side; the reaction turns it against the spin.
Mix Effects(const RotorLayout& layout, double moment_m) {
  Mix effects(static_cast<Eigen::Index>(layout.count), 4);
  for (std::size_t i = 0; i < layout.count; ++i) {
    const Eigen::Vector3d& hub = layout.hubs_B[i];
    effects.row(static_cast<Eigen::Index>(i)) << 1, -hub.y(), hub.x(),
        -static_cast<int>(layout.spins[i]) * moment_m;
  }
  return effects;
}

// Thrust of each rotor for each newton and newton metre. Columns are scaled alike before the inverse.
Mix PseudoInverse(const Mix& effects) {
  const Eigen::RowVector4d scale = effects.colwise().norm().cwiseMax(1e-12);
  const Mix even = effects.array().rowwise() / scale.array();
  const Eigen::Matrix4d inverse = (even.transpose() * even).inverse();
  return ((even * inverse).array().rowwise() / scale.array()).matrix();
}

}  // namespace

std::array<double, kMaxRotors> MixThrusts(const RotorLayout& layout, const RotorLimits& limits, double thrust,
                                          const Eigen::Vector3d& torque_B) {
  const Mix mix = PseudoInverse(Effects(layout, limits.moment_m));
  const double most = limits.thrust_n;
  std::array<double, kMaxRotors> thrusts{};

  // The largest share of roll and pitch torque for which there is a thrust that keeps every rotor within its limits.
  double share = 1;
  for (std::size_t i = 0; i < layout.count; ++i)
    thrusts[i] = mix.row(static_cast<Eigen::Index>(i)).segment<2>(1).dot(torque_B.head<2>());
  const auto lift = [&](std::size_t i) { return mix(static_cast<Eigen::Index>(i), 0); };
  for (std::size_t i = 0; i < layout.count; ++i) {
    for (std::size_t j = 0; j < layout.count; ++j) {
      const double apart = thrusts[j] / lift(j) - thrusts[i] / lift(i);
      if (apart * share > most / lift(j)) share = most / lift(j) / apart;
    }
  }
  double low = 0, high = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < layout.count; ++i) {
    thrusts[i] *= share;
    low = std::max(low, -thrusts[i] / lift(i));
    high = std::min(high, (most - thrusts[i]) / lift(i));
  }
  const double total = std::max(low, std::min(thrust, high));
  double least_yaw = -std::numeric_limits<double>::infinity(), most_yaw = -least_yaw;
  for (std::size_t i = 0; i < layout.count; ++i) {
    thrusts[i] = std::clamp(thrusts[i] + lift(i) * total, 0.0, most);
    const double turn = mix(static_cast<Eigen::Index>(i), 3);
    if (turn == 0) continue;
    const double down = -thrusts[i] / turn, up = (most - thrusts[i]) / turn;
    least_yaw = std::max(least_yaw, std::min(down, up));
    most_yaw = std::min(most_yaw, std::max(down, up));
  }
  const double yaw = std::clamp(torque_B.z(), least_yaw, most_yaw);
  for (std::size_t i = 0; i < layout.count; ++i)
    thrusts[i] = std::clamp(thrusts[i] + mix(static_cast<Eigen::Index>(i), 3) * yaw, 0.0, most);
  return thrusts;
}

std::optional<std::string> CannotFly(const RotorLayout& layout, const RotorLimits& limits, double weight_n) {
  if (layout.count < 4) return fmt::format("has {}, and thrust, roll, pitch and yaw take four", layout.count);
  const Mix effects = Effects(layout, limits.moment_m);
  const Eigen::RowVector4d scale = effects.colwise().norm().cwiseMax(1e-9);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd((effects.array().rowwise() / scale.array()).matrix(),
                                              Eigen::ComputeThinV);
  if (svd.singularValues()(3) < 1e-3) {
    constexpr std::array<const char*, 4> kAxes = {"thrust", "roll", "pitch", "yaw"};
    std::string lost;
    for (Eigen::Index axis = 0; axis < 4; ++axis) {
      if (std::abs(svd.matrixV()(axis, 3)) > 0.3)
        lost += (lost.empty() ? "" : " and ") + std::string(kAxes[static_cast<std::size_t>(axis)]);
    }
    return fmt::format(
        "the rotors cannot give thrust, roll, pitch and yaw each by itself: {} cannot be had alone", lost);
  }
  const Mix mix = PseudoInverse(effects);
  for (std::size_t i = 0; i < layout.count; ++i) {
    const double share = mix(static_cast<Eigen::Index>(i), 0);
    if (share <= 0.01 / static_cast<double>(layout.count))
      return fmt::format(
          "rotor {} would have to push down in a level hover: the centre of mass is not between the "
          "rotors",
          i + 1);
    if (share * 1.2 * weight_n > limits.thrust_n)
      return fmt::format("rotor {} carries {:.3g} N in a level hover, and gives {:.3g} N at most", i + 1,
                         share * weight_n, limits.thrust_n);
  }
  return std::nullopt;
}

}  // namespace kestrel::sim
