// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/brown_conrady.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Vector2d> BrownConrady::Project(const Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                              Eigen::Matrix2Xd* d_parameters) const {
  if (!(p_CQ.z() > 0) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
  const Vector2d m = p_CQ.head<2>() / p_CQ.z();
  const RadialTangential distortion = Distortion();
  if (!distortion.Holds(m.norm())) return std::nullopt;

  Eigen::Matrix2d d_m;
  Eigen::Matrix<double, 2, 5> d_distortion;
  const Vector2d distorted =
      distortion.Distort(m, d_point ? &d_m : nullptr, d_parameters ? &d_distortion : nullptr);
  const Vector2d f(fx, fy);
  if (d_point) {
    Eigen::Matrix<double, 2, 3> d_p;  // of m
    d_p << 1, 0, -m.x(), 0, 1, -m.y();
    *d_point = f.asDiagonal() * d_m * d_p / p_CQ.z();
  }
  if (d_parameters) {
    d_parameters->resize(2, 9);
    d_parameters->leftCols<4>() << distorted.x(), 0, 1, 0, 0, distorted.y(), 0, 1;
    d_parameters->rightCols<5>() = f.asDiagonal() * d_distortion;
  }
  return f.cwiseProduct(distorted) + Vector2d(cx, cy);
}

std::optional<Vector3d> BrownConrady::Ray(const Vector2d& uv, Eigen::Matrix<double, 3, 2>* d_pixel) const {
  const auto m = Distortion().Undistort({(uv.x() - cx) / fx, (uv.y() - cy) / fy});
  if (!m) return std::nullopt;
  const Vector3d ray = m->homogeneous().normalized();
  if (!(ray.z() > 0) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
  if (d_pixel) {
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(ray, &d_point)) return std::nullopt;
    *d_pixel = RayJacobian(ray, d_point);
  }
  return ray;
}

double BrownConrady::MaxAngle() const { return std::min(max_angle_rad, std::atan(Distortion().MaxRadius())); }

std::vector<std::string> BrownConrady::ParameterNames() const {
  return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
}
Eigen::VectorXd BrownConrady::Parameters() const {
  return Eigen::Matrix<double, 9, 1>(fx, fy, cx, cy, k1, k2, p1, p2, k3);
}
void BrownConrady::SetParameters(const Eigen::VectorXd& all) {
  fx = all[0], fy = all[1], cx = all[2], cy = all[3];
  k1 = all[4], k2 = all[5], p1 = all[6], p2 = all[7], k3 = all[8];
}

}  // namespace kestrel::vision
