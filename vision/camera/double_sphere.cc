// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/double_sphere.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// On the second sphere, as in the unified model: the cosine at which the picture ends in infinity (alpha up
// to 1/2) or folds back.
double MinCosineOnSecond(double alpha) { return alpha <= 0.5 ? -alpha / (1 - alpha) : -(1 - alpha) / alpha; }

// The distance from the first sphere's centre, xi behind which the second's is, along a direction with cosine
// c from the second's centre, is 1 here: how far that is, times c, less xi.
double CosineOnFirst(double c, double xi) { return c * (xi * c + std::sqrt(1 - xi * xi * (1 - c * c))) - xi; }

}  // namespace

std::optional<Vector2d> DoubleSphere::Project(const Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                              Eigen::Matrix2Xd* d_parameters) const {
  const double d1 = p_CQ.norm();
  if (!(p_CQ.z() > CosineOnFirst(MinCosineOnSecond(alpha), xi) * d1)) return std::nullopt;
  if (!WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
  const double z2 = p_CQ.z() + xi * d1;
  const double d2 = std::hypot(p_CQ.x(), p_CQ.y(), z2);
  const double depth = alpha * d2 + (1 - alpha) * z2;
  if (!(depth > 0)) return std::nullopt;
  const Vector2d m = p_CQ.head<2>() / depth, f(fx, fy);
  if (d_point) {
    const Vector3d d_z2 = Vector3d::UnitZ() + xi / d1 * p_CQ;
    const Vector3d d_d2 = (Vector3d(p_CQ.x(), p_CQ.y(), 0) + z2 * d_z2) / d2;
    const Vector3d d_depth = alpha * d_d2 + (1 - alpha) * d_z2;
    Eigen::Matrix<double, 2, 3> d_p;  // of m
    d_p << 1, 0, 0, 0, 1, 0;
    d_p -= m * d_depth.transpose();
    *d_point = f.asDiagonal() * d_p / depth;
  }
  if (d_parameters) {
    d_parameters->resize(2, 6);
    d_parameters->leftCols<4>() << m.x(), 0, 1, 0, 0, m.y(), 0, 1;
    d_parameters->col(4) = -f.cwiseProduct(m) * d1 * (alpha * z2 / d2 + 1 - alpha) / depth;
    d_parameters->col(5) = -f.cwiseProduct(m) * (d2 - z2) / depth;
  }
  return f.cwiseProduct(m) + Vector2d(cx, cy);
}

std::optional<Vector3d> DoubleSphere::Ray(const Vector2d& uv, Eigen::Matrix<double, 3, 2>* d_pixel) const {
  const Vector2d m((uv.x() - cx) / fx, (uv.y() - cy) / fy);
  const double r2 = m.squaredNorm(), root = 1 - (2 * alpha - 1) * r2;
  if (!(root > 0)) return std::nullopt;
  const double mz = (1 - alpha * alpha * r2) / (alpha * std::sqrt(root) + 1 - alpha);
  const double lambda = (mz * xi + std::sqrt(mz * mz + (1 - xi * xi) * r2)) / (mz * mz + r2);
  const Vector3d ray(lambda * m.x(), lambda * m.y(), lambda * mz - xi);
  if (!(ray.z() > CosineOnFirst(MinCosineOnSecond(alpha), xi)) || !WithinAngle(ray, max_angle_rad)) {
    return std::nullopt;
  }
  if (d_pixel) {
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(ray, &d_point)) return std::nullopt;
    *d_pixel = RayJacobian(ray, d_point);
  }
  return ray;
}

double DoubleSphere::MaxAngle() const {
  return std::min(max_angle_rad, std::acos(CosineOnFirst(MinCosineOnSecond(alpha), xi)));
}

std::vector<std::string> DoubleSphere::ParameterNames() const {
  return {"fx", "fy", "cx", "cy", "xi", "alpha"};
}
Eigen::VectorXd DoubleSphere::Parameters() const {
  return Eigen::Matrix<double, 6, 1>(fx, fy, cx, cy, xi, alpha);
}
void DoubleSphere::SetParameters(const Eigen::VectorXd& all) {
  fx = all[0], fy = all[1], cx = all[2], cy = all[3], xi = all[4], alpha = all[5];
}

}  // namespace kestrel::vision
