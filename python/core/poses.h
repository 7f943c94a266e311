// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/eigen.h>

#include <Eigen/Geometry>

#include "geometry/pose.h"

namespace kestrel::python {

// Of a position and a rotation matrix; ValueError of what is none.
Pose PoseOf(const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation);
Eigen::Quaterniond RotationOf(const Eigen::Matrix3d& rotation);

}  // namespace kestrel::python
