// SPDX-License-Identifier: Apache-2.0
#include "geometry/pose.h"

#include <cmath>

namespace kestrel {

Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& v_rad) {
  const double angle = v_rad.norm();
  // sin(a/2)/a, by its series where the quotient would lose digits
  const double k = angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(angle / 2);
  q.vec() = k * v_rad;
  return q.normalized();
}

Eigen::Vector3d LogRotation(const Eigen::Quaterniond& R) {
  const double sign = R.w() < 0 ? -1 : 1;  // q and -q are the same rotation: take the short way
  const Eigen::Vector3d v = sign * R.vec();
  const double s = v.norm();
  if (s < 1e-9) return 2 * v;
  return 2 * std::atan2(s, sign * R.w()) / s * v;
}

}  // namespace kestrel
