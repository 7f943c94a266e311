// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/ray_pose.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace kestrel::vision {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Pose> PlanePoseFromRays(std::span<const PlaneRay> pairs) {
  if (pairs.size() < 4) return std::nullopt;
  // The plane's points brought to the origin and to unit size.
  Vector2d middle = Vector2d::Zero();
  for (const PlaneRay& pair : pairs) middle += pair.p_T / static_cast<double>(pairs.size());
  double size = 0;
  for (const PlaneRay& pair : pairs) size += (pair.p_T - middle).norm() / static_cast<double>(pairs.size());
  if (!(size > 0)) return std::nullopt;

  // H (x, y, 1) lies along the ray: nothing of it across.
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PlaneRay& pair : pairs) {
    const Vector3d q = ((pair.p_T - middle) / size).homogeneous();
    const Vector3d across = pair.ray_C.unitOrthogonal();
    for (const Vector3d& a : {across, Vector3d(pair.ray_C.cross(across))}) {
      Eigen::Matrix<double, 9, 1> row;
      row << a * q.x(), a * q.y(), a * q.z();
      normal += row * row.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[1] > 1e-12 * solver.eigenvalues()[8]))
    return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Matrix3d H = Eigen::Map<const Matrix3d>(h.data());
  double forward = 0;
  for (const PlaneRay& pair : pairs)
    forward += pair.ray_C.dot(H * ((pair.p_T - middle) / size).homogeneous());
  const double scale = 2 / (H.col(0).norm() + H.col(1).norm());
  H *= forward < 0 ? -scale : scale;
  Matrix3d columns;
  columns << H.col(0), H.col(1), H.col(0).cross(H.col(1));
  const Eigen::JacobiSVD<Matrix3d> svd(columns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (!R.allFinite() || !(R.determinant() > 0)) return std::nullopt;
  const Vector3d p = size * H.col(2) - R.leftCols<2>() * middle;
  return Pose{Eigen::Quaterniond(R), p};
}

}  // namespace kestrel::vision
