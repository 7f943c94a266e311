// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/extended_unified.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// The domain: z > -limit d.
double DepthLimit(double alpha) { return alpha <= 0.5 ? alpha / (1 - alpha) : (1 - alpha) / alpha; }

}  // namespace

std::optional<Vector2d> ExtendedUnified::Project(const Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                                 Eigen::Matrix2Xd* d_parameters) const {
  const double z = p_CQ.z(), across = p_CQ.head<2>().squaredNorm(), d = std::sqrt(beta * across + z * z);
  if (!(z > -DepthLimit(alpha) * d) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
  const double depth = alpha * d + (1 - alpha) * z;
  if (!(depth > 0)) return std::nullopt;
  const Vector2d m = p_CQ.head<2>() / depth, f(fx, fy);
  if (d_point) {
    const Vector3d d_depth =
        alpha / d * Vector3d(beta * p_CQ.x(), beta * p_CQ.y(), z) + (1 - alpha) * Vector3d::UnitZ();
    Eigen::Matrix<double, 2, 3> d_p;  // of m
    d_p << 1, 0, 0, 0, 1, 0;
    d_p -= m * d_depth.transpose();
    *d_point = f.asDiagonal() * d_p / depth;
  }
  if (d_parameters) {
    d_parameters->resize(2, 6);
    d_parameters->leftCols<4>() << m.x(), 0, 1, 0, 0, m.y(), 0, 1;
    d_parameters->col(4) = -f.cwiseProduct(m) * (d - z) / depth;
    d_parameters->col(5) = -f.cwiseProduct(m) * alpha * across / (2 * d * depth);
  }
  return f.cwiseProduct(m) + Vector2d(cx, cy);
}

std::optional<Vector3d> ExtendedUnified::Ray(const Vector2d& uv, Eigen::Matrix<double, 3, 2>* d_pixel) const {
  const Vector2d m((uv.x() - cx) / fx, (uv.y() - cy) / fy);
  const double r2 = beta * m.squaredNorm(), root = 1 - (2 * alpha - 1) * r2;
  if (!(root > 0)) return std::nullopt;
  const double z = (1 - alpha * alpha * r2) / (alpha * std::sqrt(root) + 1 - alpha);
  const Vector3d ray = Vector3d(m.x(), m.y(), z).normalized();
  const double d = std::sqrt(beta * ray.head<2>().squaredNorm() + ray.z() * ray.z());
  if (!(ray.z() > -DepthLimit(alpha) * d) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
  if (d_pixel) {
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(ray, &d_point)) return std::nullopt;
    *d_pixel = RayJacobian(ray, d_point);
  }
  return ray;
}

double ExtendedUnified::MaxAngle() const {
  const double limit = DepthLimit(alpha);
  const double own = M_PI / 2 + std::atan2(limit * std::sqrt(beta), std::sqrt(1 - limit * limit));
  return std::min(max_angle_rad, own);
}

std::vector<std::string> ExtendedUnified::ParameterNames() const {
  return {"fx", "fy", "cx", "cy", "alpha", "beta"};
}
Eigen::VectorXd ExtendedUnified::Parameters() const {
  return Eigen::Matrix<double, 6, 1>(fx, fy, cx, cy, alpha, beta);
}
void ExtendedUnified::SetParameters(const Eigen::VectorXd& all) {
  fx = all[0], fy = all[1], cx = all[2], cy = all[3], alpha = all[4], beta = all[5];
}

}  // namespace kestrel::vision
