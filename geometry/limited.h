// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel {

// The vector, or one of the same direction that is `limit` long where it is longer than that.
inline Eigen::Vector2d Limited(const Eigen::Vector2d& v, double limit) {
  const double norm = v.norm();
  return norm > limit ? Eigen::Vector2d(v * (limit / norm)) : v;
}

}  // namespace kestrel
