// SPDX-License-Identifier: Apache-2.0
#include "mission/touch_down/wind_from_lean.h"

#include <algorithm>
#include <cmath>

#include "base/gravity.h"

namespace kestrel::mission {
namespace {

constexpr double kSmooth_s = 3;
constexpr double kMostUpright = 0.3;  // cosine of a lean beyond which it flies no more

}  // namespace

void WindFromLean::Add(const control::VehicleState& state) {
  const Eigen::Vector3d thrust_N = state.R_NB * Eigen::Vector3d(0, 0, -1);
  // It leans into the wind: the thrust's level part points to where the air comes from.
  const Eigen::Vector2d air_N =
      -kGravity_m_s2 / drag_per_s_ * thrust_N.head<2>() / std::max(kMostUpright, -thrust_N.z());
  const double share = begun_ ? 1 - std::exp(-std::max(0.0, state.t_s - t_s_) / kSmooth_s) : 1;
  air_N_ += share * (air_N - air_N_);
  t_s_ = state.t_s;
  begun_ = true;
}

}  // namespace kestrel::mission
