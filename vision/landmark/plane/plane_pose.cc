// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/plane/plane_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vision/least_squares.h"

namespace kestrel::vision {
namespace {

// The pixel of a point of the plane, with its derivative by (translation in C, rotation vector in C).
std::optional<Eigen::Vector2d> Projected(const Eigen::Vector2d& on_plane, const Pinhole& camera,
                                         const Pose& X_CT, Eigen::Matrix<double, 2, 6>& J) {
  const Eigen::Vector3d arm_C = X_CT.R * Eigen::Vector3d(on_plane.x(), on_plane.y(), 0);
  const Eigen::Vector3d p_C = arm_C + X_CT.p;
  const auto uv = camera.Project(p_C);
  if (!uv) return std::nullopt;
  Eigen::Matrix<double, 2, 3> d_uv;  // of the pixel with respect to p_C
  d_uv << camera.fx / p_C.z(), 0, -camera.fx * p_C.x() / (p_C.z() * p_C.z()),  //
      0, camera.fy / p_C.z(), -camera.fy * p_C.y() / (p_C.z() * p_C.z());
  J << d_uv, -d_uv * Skew(arm_C);  // p_C moves by dt + dtheta x arm
  return uv;
}

}  // namespace

double RectangleAspect(const Eigen::Matrix3d& H_unit, const Pinhole& camera) {
  const Eigen::Matrix3d M = camera.K().inverse() * H_unit;
  return M.col(1).norm() / M.col(0).norm();  // eq. (3.21)
}

std::optional<Pose> PoseFromHomography(const Eigen::Matrix3d& H_w, const Pinhole& camera) {
  const Eigen::Matrix3d M = camera.K().inverse() * H_w;  // eq. (3.22)
  const double scale = (M.col(0).norm() + M.col(1).norm()) / 2;
  if (!std::isfinite(scale) || !(scale > 0)) return std::nullopt;
  const double lambda = (M(2, 2) < 0 ? -1 : 1) / scale;  // eq. (3.23)
  Eigen::Matrix3d R;
  R.col(0) = lambda * M.col(0);
  R.col(1) = lambda * M.col(1);
  R.col(2) = R.col(0).cross(R.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 1e-6)) return std::nullopt;
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();  // eq. (3.24)
  if (nearest.determinant() < 0) return std::nullopt;
  const Pose X_CT{Eigen::Quaterniond(nearest).normalized(), lambda * M.col(2)};  // eq. (3.25)
  if (!(X_CT.p.z() > 0)) return std::nullopt;
  return X_CT;
}

Eigen::Matrix3d HomographyFromPose(const Pose& X_CT, const Pinhole& camera) {
  const Eigen::Matrix3d R = X_CT.R.toRotationMatrix();
  Eigen::Matrix3d M;
  M << R.col(0), R.col(1), X_CT.p;
  return camera.K() * M;
}

std::optional<Eigen::Matrix<double, 6, 6>> PoseInformation(std::span<const Eigen::Vector2d> on_plane,
                                                           const Pinhole& camera, const Pose& X_CT) {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Eigen::Vector2d& point : on_plane) {
    Eigen::Matrix<double, 2, 6> J;
    if (!Projected(point, camera, X_CT, J)) return std::nullopt;
    information += J.transpose() * J;
  }
  return information;
}

Eigen::Matrix<double, 6, 6> CovarianceOfShift(const Pose& X_CT, double sigma_rad) {
  Eigen::Matrix<double, 6, 2> A;
  A.topRows<3>() = -Skew(X_CT.p).leftCols<2>();
  A.bottomRows<3>() = Eigen::Matrix<double, 3, 2>::Identity();
  return sigma_rad * sigma_rad * A * A.transpose();
}

std::optional<PlanePose> RefinePlanePose(std::span<const PointPair> pairs, const Pinhole& camera,
                                         const Pose& X_CT_start, double sigma_px) {
  if (pairs.size() < 4) return std::nullopt;
  Pose X_CT = X_CT_start;
  for (int iteration = 0;; ++iteration) {
    NormalEquations<double, 6> normal;
    for (const PointPair& pair : pairs) {
      Eigen::Matrix<double, 2, 6> J;
      const auto uv = Projected(pair.from, camera, X_CT, J);
      if (!uv) return std::nullopt;
      normal.Add<2>(J, pair.to - *uv);
    }
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal.H);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
    const Eigen::Matrix<double, 6, 1> step = solver.solve(normal.g);
    if (!step.allFinite()) return std::nullopt;
    if (iteration >= 30 || step.norm() < 1e-9) {
      const double n = static_cast<double>(pairs.size());
      const double seen =
          std::sqrt(normal.squares / std::max(2 * n - 6, 1.0));  // deviation of one coordinate
      const double sigma = std::max(sigma_px, seen);
      return PlanePose{X_CT, sigma * sigma * solver.solve(Eigen::Matrix<double, 6, 6>::Identity()),
                       std::sqrt(normal.squares / n)};
    }
    X_CT.p += step.head<3>();
    X_CT.R = (ExpRotation(step.tail<3>()) * X_CT.R).normalized();
  }
}

}  // namespace kestrel::vision
