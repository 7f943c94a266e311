// SPDX-License-Identifier: Apache-2.0
#include "geometry/tait_bryan.h"

#include <cmath>
#include <numbers>

namespace kestrel {

Eigen::Matrix3d RotationFromTaitBryan(const TaitBryan& a) {
  // eq. (4.3) are the transposes of these three: they turn the axes, these turn the vectors
  return (Eigen::AngleAxisd(a.yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(a.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

TaitBryan TaitBryanFromRotation(const Eigen::Matrix3d& R_AB) {
  const Eigen::Matrix3d r = R_AB.transpose();  // the thesis's matrix, eq. (4.4)
  TaitBryan a;
  const double level = std::hypot(r(0, 0), r(0, 1));
  a.pitch = std::atan2(-r(0, 2), level);  // eq. (4.5); the arctangent keeps its digits near the poles
  if (level > 1e-9) {
    a.yaw = std::atan2(r(0, 1), r(0, 0));
    a.roll = std::atan2(r(1, 2), r(2, 2));
  } else {
    a.yaw = std::atan2(-r(1, 0), r(1, 1));
  }
  return a;
}

double YawOf(const Eigen::Quaterniond& R_AB) {
  const Eigen::Vector3d forward_A = R_AB * Eigen::Vector3d::UnitX();
  return std::atan2(forward_A.y(), forward_A.x());
}

Eigen::Quaterniond HeadingRotation(double yaw) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

double WrapAngle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

}  // namespace kestrel
