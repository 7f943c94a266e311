// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/constant_velocity_filter.h"

#include <Eigen/LU>

namespace kestrel::control {

ConstantVelocityFilter::ConstantVelocityFilter(const Eigen::Vector3d& position, double position_sigma,
                                               const Eigen::Vector3d& velocity, double velocity_sigma,
                                               double acceleration)
    : P_(Matrix6::Zero()), acceleration_(acceleration) {
  x_ << position, velocity;
  P_.diagonal().head<3>().setConstant(position_sigma * position_sigma);
  P_.diagonal().tail<3>().setConstant(velocity_sigma * velocity_sigma);
}

void ConstantVelocityFilter::Predict(double dt_s) {
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(dt_s);
  const double q = acceleration_ * acceleration_;
  Matrix6 Q = Matrix6::Zero();
  Q.topLeftCorner<3, 3>().diagonal().setConstant(q * dt_s * dt_s * dt_s / 3);
  Q.topRightCorner<3, 3>().diagonal().setConstant(q * dt_s * dt_s / 2);
  Q.bottomLeftCorner<3, 3>().diagonal().setConstant(q * dt_s * dt_s / 2);
  Q.bottomRightCorner<3, 3>().diagonal().setConstant(q * dt_s);
  x_ = F * x_;
  P_ = F * P_ * F.transpose() + Q;
}

void ConstantVelocityFilter::Correct(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d S = P_.topLeftCorner<3, 3>() + covariance;
  const Eigen::Matrix<double, 6, 3> K = P_.leftCols<3>() * S.inverse();
  x_ += K * (position - x_.head<3>());
  // Joseph's form keeps the covariance symmetric and positive
  Matrix6 I_KH = Matrix6::Identity();
  I_KH.leftCols<3>() -= K;
  P_ = I_KH * P_ * I_KH.transpose() + K * covariance * K.transpose();
}

}  // namespace kestrel::control
