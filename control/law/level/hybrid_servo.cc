// SPDX-License-Identifier: Apache-2.0
#include "control/law/level/hybrid_servo.h"

#include <Eigen/LU>
#include <cmath>

namespace kestrel::control {

Eigen::Matrix<double, 3, 6> DepthPointInteraction(const Eigen::Vector2d& s, double Z) {
  Eigen::Matrix<double, 3, 6> L;
  L.topRows<2>() = PointInteraction(s, Z);
  L.row(2) << 0, 0, -1 / Z, -s.y(), s.x(), 0;
  return L;
}

Twist HybridTwist(const ImagePoint& now, const ImagePoint& wanted, const Eigen::Vector3d& theta_u,
                  double lambda_per_s) {
  const Eigen::Matrix<double, 3, 6> L = DepthPointInteraction(now.s, now.Z);
  Eigen::Vector3d e;
  e << now.s - wanted.s, std::log(now.Z / wanted.Z);
  const Eigen::Vector3d w = -lambda_per_s * theta_u;
  const Eigen::Matrix3d L_v = L.leftCols<3>(), L_w = L.rightCols<3>();
  return {-L_v.inverse() * (lambda_per_s * e + L_w * w), w};
}

}  // namespace kestrel::control
