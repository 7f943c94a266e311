// SPDX-License-Identifier: Apache-2.0
#include "python/core/poses.h"

namespace kestrel::python {
namespace py = pybind11;

Eigen::Quaterniond RotationOf(const Eigen::Matrix3d& rotation) {
  if (!rotation.allFinite()) throw py::value_error("rotation has a number that is not finite");
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-6 ||
      rotation.determinant() < 0)
    throw py::value_error(
        "rotation is none: its columns must be of length 1, at right angles, and right-handed");
  return Eigen::Quaterniond(rotation).normalized();
}

Pose PoseOf(const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation) {
  if (!position.allFinite()) throw py::value_error("position has a number that is not finite");
  return {RotationOf(rotation), position};
}

}  // namespace kestrel::python
