// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/tilt_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

// The rotation vector, perpendicular to both, that turns unit vector a into b.
Eigen::Vector3d Turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d axis = a.cross(b);
  const double s = axis.norm();
  return s > 1e-12 ? Eigen::Vector3d(std::atan2(s, a.dot(b)) / s * axis) : axis;
}

}  // namespace

TiltAlignment::TiltAlignment(const Options& options)
    : options_(options), P_(Eigen::Matrix2d::Identity() * std::pow(Radians(options.initial_deg), 2)) {}

void TiltAlignment::Predict(double dt_s) {
  P_.diagonal().array() += std::pow(Radians(options_.drift_deg_per_root_s), 2) * dt_s;
}

void TiltAlignment::Correct(double dt_s, const Eigen::Vector3d& down_C, const Eigen::Vector3d& normal_C,
                            const Eigen::Matrix3d& covariance) {
  // The camera looks down within some tens of degrees, so x and y of C span the tilts.
  const Eigen::Vector2d seen = Turn(down_C, normal_C).head<2>();
  Eigen::Matrix2d R = covariance.topLeftCorner<2, 2>() +
                      Eigen::Matrix2d::Identity() * std::pow(Radians(options_.autopilot_noise_deg), 2);
  if (dt_s > 0) R *= std::max(1.0, options_.correlation_s / dt_s);
  const Eigen::Matrix2d K = P_ * (P_ + R).inverse();
  offset_ += K * (seen - offset_);
  P_ = ((Eigen::Matrix2d::Identity() - K) * P_).eval();
  P_ = ((P_ + P_.transpose()) / 2).eval();
}

Eigen::Vector3d TiltAlignment::Apply(const Eigen::Vector3d& down_C) const {
  return ExpRotation({offset_.x(), offset_.y(), 0}) * down_C;
}

double TiltAlignment::sigma() const {
  return std::sqrt(P_.trace() / 2 + std::pow(Radians(options_.autopilot_noise_deg), 2));
}

void FuseNormal(const Eigen::Vector3d& normal_C, double sigma, Pose& X_CT,
                Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::Vector3d n = X_CT.R * Eigen::Vector3d::UnitZ();
  // Two directions perpendicular to the normal: the tilts that it shows.
  const Eigen::Vector3d a = n.unitOrthogonal(), b = n.cross(a);
  Eigen::Matrix<double, 2, 6> H = Eigen::Matrix<double, 2, 6>::Zero();
  H.row(0).tail<3>() = a;
  H.row(1).tail<3>() = b;
  const Eigen::Vector3d turn = Turn(n, normal_C);
  const Eigen::Vector2d residual(a.dot(turn), b.dot(turn));
  const Eigen::Matrix2d S = H * covariance * H.transpose() + Eigen::Matrix2d::Identity() * sigma * sigma;
  const Eigen::Matrix<double, 6, 2> K = covariance * H.transpose() * S.inverse();
  const Eigen::Matrix<double, 6, 1> step = K * residual;
  X_CT.p += step.head<3>();
  X_CT.R = (ExpRotation(step.tail<3>()) * X_CT.R).normalized();
  covariance = (covariance - K * S * K.transpose()).eval();
  covariance = ((covariance + covariance.transpose()) / 2).eval();
}

}  // namespace kestrel::control
