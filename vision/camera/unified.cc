// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/unified.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// The cosine of the maximum angle that the mirror or lens itself can show.
double MinCosine(double xi) { return xi <= 1 ? -xi : -1 / xi; }

}  // namespace

std::optional<Vector2d> Unified::Project(const Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                         Eigen::Matrix2Xd* d_parameters) const {
  const double r = p_CQ.norm(), z = p_CQ.z();
  if (!(z > MinCosine(xi) * r) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
  // z + xi r; behind the centre so that nothing cancels at xi = 1.
  const double depth = z > 0 ? z + xi * r : p_CQ.head<2>().squaredNorm() / (r - z) + (xi - 1) * r;
  if (!(depth > 0)) return std::nullopt;
  const Vector2d m = p_CQ.head<2>() / depth;
  const RadialTangential distortion = Distortion();
  if (!distortion.Holds(m.norm())) return std::nullopt;

  Eigen::Matrix2d d_m, K;
  Eigen::Matrix<double, 2, 5> d_distortion;
  const Vector2d distorted = distortion.Distort(m, &d_m, d_parameters ? &d_distortion : nullptr);
  K << fx, skew, 0, fy;
  if (d_point) {
    Eigen::Matrix<double, 2, 3> d_p;  // of m
    d_p << 1, 0, 0, 0, 1, 0;
    const Vector3d d_depth = Vector3d::UnitZ() + xi / r * p_CQ;
    d_p -= m * d_depth.transpose();
    *d_point = K * d_m * d_p / depth;
  }
  if (d_parameters) {
    d_parameters->resize(2, 10);
    d_parameters->leftCols<4>() << distorted.x(), 0, 1, 0, 0, distorted.y(), 0, 1;
    d_parameters->col(4) = K * d_m * m * (-r / depth);
    d_parameters->middleCols<4>(5) = K * d_distortion.leftCols<4>();
    d_parameters->col(9) << distorted.y(), 0;
  }
  return K * distorted + Vector2d(cx, cy);
}

std::optional<Vector3d> Unified::Ray(const Vector2d& uv, Eigen::Matrix<double, 3, 2>* d_pixel) const {
  const double y = (uv.y() - cy) / fy;
  const auto m = Distortion().Undistort({(uv.x() - cx - skew * y) / fx, y});
  if (!m) return std::nullopt;
  const double r2 = m->squaredNorm(), root = 1 + (1 - xi * xi) * r2;
  if (!(root > 0)) return std::nullopt;
  const double lambda = (xi + std::sqrt(root)) / (1 + r2);  // eq. (6.5)
  const Vector3d ray(lambda * m->x(), lambda * m->y(), lambda - xi);
  if (!(ray.z() > MinCosine(xi)) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
  if (d_pixel) {
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(ray, &d_point)) return std::nullopt;
    *d_pixel = RayJacobian(ray, d_point);
  }
  return ray;
}

double Unified::MaxAngle() const {
  const double own = std::acos(MinCosine(xi)), radius = Distortion().MaxRadius();
  const double root = 1 + (1 - xi * xi) * radius * radius;
  if (!std::isfinite(radius) || !(root > 0)) return std::min(max_angle_rad, own);
  const double lambda = (xi + std::sqrt(root)) / (1 + radius * radius);
  return std::min({max_angle_rad, own, std::atan2(lambda * radius, lambda - xi)});
}

std::vector<std::string> Unified::ParameterNames() const {
  return {"fx", "fy", "cx", "cy", "xi", "k1", "k2", "p1", "p2", "skew"};
}
Eigen::VectorXd Unified::Parameters() const {
  return Eigen::Matrix<double, 10, 1>(fx, fy, cx, cy, xi, k1, k2, p1, p2, skew);
}
void Unified::SetParameters(const Eigen::VectorXd& all) {
  fx = all[0], fy = all[1], cx = all[2], cy = all[3];
  xi = all[4], k1 = all[5], k2 = all[6], p1 = all[7], p2 = all[8], skew = all[9];
}

}  // namespace kestrel::vision
