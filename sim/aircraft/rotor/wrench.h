// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::sim {

// Force, N, and torque, N m, in B.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

}  // namespace kestrel::sim
