// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "geometry/pose.h"

namespace kestrel::vision {

// (translation, m; rotation vector, rad) from a pose to another, both in C.
inline Eigen::Matrix<double, 6, 1> Between(const Pose& from, const Pose& to) {
  Eigen::Matrix<double, 6, 1> d;
  d << to.p - from.p, LogRotation(to.R * from.R.conjugate());
  return d;
}

}  // namespace kestrel::vision
