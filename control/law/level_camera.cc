// SPDX-License-Identifier: Apache-2.0
#include "control/law/level_camera.h"

#include <cassert>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {

Eigen::Quaterniond LevelRotation(double roll, double pitch, const Eigen::Quaterniond& R_BC) {
  const Eigen::Quaterniond R_HB(RotationFromTaitBryan({.yaw = 0, .pitch = pitch, .roll = roll}));
  return R_BC.conjugate() * R_HB * R_BC;  // R_HV is R_BC
}

Eigen::Vector3d LevelDown(const Eigen::Quaterniond& R_BC) {
  return R_BC.conjugate() * Eigen::Vector3d::UnitZ();
}

UncertainBearing Levelled(const UncertainBearing& bearing_C, const Eigen::Quaterniond& R_VC,
                          const Eigen::Matrix3d& tilt_V) {
  const Eigen::Matrix3d R = R_VC.toRotationMatrix();
  const Eigen::Vector3d s = R * bearing_C.s;
  const Eigen::Matrix3d K = Skew(s);
  return {s, R * bearing_C.covariance * R.transpose() + K * tilt_V * K.transpose()};
}

std::optional<UncertainPoint> OnImagePlane(const UncertainBearing& bearing) {
  const double z = bearing.s.z();
  if (!(z > 0)) return std::nullopt;
  const Eigen::Vector2d s = bearing.s.head<2>() / z;
  if (!s.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 2, 3> J;
  J << 1 / z, 0, -s.x() / z, 0, 1 / z, -s.y() / z;
  return UncertainPoint{s, J * bearing.covariance * J.transpose()};
}

Eigen::MatrixXd LevelInteraction(const Eigen::MatrixXd& L_V, const Eigen::Vector3d& down_V) {
  assert(L_V.cols() == 6);
  Eigen::MatrixXd L(L_V.rows(), 4);
  L << L_V.leftCols<3>(), L_V.rightCols<3>() * down_V;
  return L;
}

}  // namespace kestrel::control
