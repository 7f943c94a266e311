// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/deck/oscillator.h"

#include <cmath>

namespace kestrel::control {

Eigen::Matrix2d Oscillator::Transition(double dt_s) const {
  const double decay = damping * w, swing = w * std::sqrt(1 - damping * damping);
  const double e = std::exp(-decay * dt_s), c = std::cos(swing * dt_s), s = std::sin(swing * dt_s) / swing;
  Eigen::Matrix2d F;
  F << c + decay * s, s, -w * w * s, c - decay * s;
  return e * F;
}

Eigen::Matrix2d Oscillator::Stationary() const {
  return Eigen::Vector2d(sigma * sigma, w * w * sigma * sigma).asDiagonal();
}

Eigen::Matrix2d Oscillator::Noise(double dt_s) const {
  const Eigen::Matrix2d F = Transition(dt_s);
  return Stationary() - F * Stationary() * F.transpose();
}

}  // namespace kestrel::control
