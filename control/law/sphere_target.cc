// SPDX-License-Identifier: Apache-2.0
#include "control/law/sphere_target.h"

#include "control/law/point_servo.h"

namespace kestrel::control {

SphereImage SphereImageOf(const Eigen::Vector3d& p_CT, double D) {
  return {p_CT.head<2>() / p_CT.z(), D / p_CT.z()};  // eq. (5.16)
}

double SphereDepth(const SphereImage& image, double D) { return D / image.diameter; }

Eigen::Matrix<double, 3, 6> SphereInteraction(const SphereImage& image, double Z) {
  const double x = image.s.x(), y = image.s.y(), d = image.diameter;
  Eigen::Matrix<double, 3, 6> L;
  L << PointInteraction(image.s, Z), 0, 0, d / Z, d * y, -d * x, 0;  // eq. (5.18)
  return L;
}

Eigen::Matrix3d FollowInteraction(const SphereImage& image, double Z) {
  const Eigen::Matrix<double, 3, 6> L = SphereInteraction(image, Z);
  Eigen::Matrix3d follow;
  follow << L.col(1), L.col(2), L.col(4);  // eq. (5.19)
  return follow;
}

Eigen::Matrix3d FollowInverse(const SphereImage& image, double Z) {
  const double x = image.s.x(), y = image.s.y(), d = image.diameter;
  Eigen::Matrix3d inverse;
  inverse << 0, -Z, Z * y / d,         // eq. (5.20)
      -Z * x, 0, Z * (x * x + 1) / d,  //
      -1, 0, x / d;
  return inverse;
}

Eigen::Matrix3d DecoupledInteraction(const SphereImage& image, double Z) {
  const double x = image.s.x();
  Eigen::Matrix3d L;
  L << 0, 0, -(x * x + 1), -1 / Z, 0, 0, 0, image.diameter / Z, 0;  // eq. (5.24)
  return L;
}

Eigen::Matrix3d DecoupledInverse(const SphereImage& image, double Z) {
  const double x = image.s.x();
  Eigen::Matrix3d inverse;
  inverse << 0, -Z, 0, 0, 0, Z / image.diameter, -1 / (x * x + 1), 0, 0;  // eq. (5.25)
  return inverse;
}

Eigen::Vector3d SphereDrift(const SphereImage& image, double Z, const Eigen::Vector3d& v_C) {
  return -SphereInteraction(image, Z).leftCols<3>() * v_C;
}

FollowStep FollowVelocity(const SphereImage& now, const SphereImage& wanted, double Z,
                          FollowCoupling coupling, const Eigen::Vector3d& lambda_per_s,
                          const Eigen::Vector3d& drift) {
  if (Z <= 0 || now.diameter <= 0) return {ServoState::kDepthNotPositive, Eigen::Vector3d::Zero()};
  const Eigen::Matrix3d inverse =
      coupling == FollowCoupling::kCoupled ? FollowInverse(now, Z) : DecoupledInverse(now, Z);
  const Eigen::Vector3d error = now.Vector() - wanted.Vector();
  const Eigen::Vector3d velocity = -inverse * (lambda_per_s.cwiseProduct(error) + drift);  // eq. (5.21)
  if (!velocity.allFinite()) return {};
  return {ServoState::kRegular, velocity};
}

}  // namespace kestrel::control
