// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "geometry/pose.h"

namespace kestrel::control {

// A feature's derivative by the twist (v, w) of the camera, by its definition: the camera is displaced along
// each axis and turned about it, and the feature of a point that stands still is measured again. Central
// differences err by h^2 times the third derivative and by the rounding over h: some 1e-10 times the size of
// the entries for the distances of these tests.
inline constexpr double kNumericStep = 1e-5;
template <class Feature>  // a column vector from p_CQ
Eigen::MatrixXd NumericInteraction(const Feature& feature, const Eigen::Vector3d& p_CQ) {
  Eigen::MatrixXd L(feature(p_CQ).size(), 6);
  for (int i = 0; i < 6; ++i) {
    const auto displaced = [&](double by) {
      const Eigen::Vector3d d = by * Eigen::Vector3d::Unit(i % 3);
      const Pose X_CD = i < 3 ? Pose{Eigen::Quaterniond::Identity(), d} : Pose{ExpRotation(d), {0, 0, 0}};
      return feature(X_CD.Inverse() * p_CQ);
    };
    L.col(i) = (displaced(kNumericStep) - displaced(-kNumericStep)) / (2 * kNumericStep);
  }
  return L;
}

}  // namespace kestrel::control
