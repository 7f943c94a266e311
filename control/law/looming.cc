// SPDX-License-Identifier: Apache-2.0
#include "control/law/looming.h"

#include <cmath>

namespace kestrel::control {

Looming LoomingOf(const Eigen::Vector2d& p, const Eigen::Vector2d& v) {
  const double r2 = p.squaredNorm();
  if (!(r2 > 0)) return {};
  return {-p.dot(v) / r2, (p.x() * v.y() - p.y() * v.x()) / r2};
}

// The relative velocity over the range has the parts -growth along the line of sight and bearing_rate across.
LoomingApproach ApproachOf(const Looming& l) {
  const double speed2 = l.growth * l.growth + l.bearing_rate * l.bearing_rate;
  if (!(l.growth > 0)) return {};
  return {l.growth / speed2, std::abs(l.bearing_rate) / std::sqrt(speed2)};
}

}  // namespace kestrel::control
