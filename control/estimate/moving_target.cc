// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/moving_target.h"

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {
constexpr double kFirstSpeed_m_s = 2;  // deviation of the velocity before anything is known of it
constexpr double kOdd = 6;             // deviations off where it should be: something else was measured
constexpr double kOdd_s = 0.3;         // what is odd for longer is believed, and what was before is not
}  // namespace

MovingTarget::MovingTarget(const Pose& X_BC, const MovingTargetOptions& options)
    : X_BC_(X_BC), options_(options) {}

void MovingTarget::AddState(const VehicleState& state) {
  if (last_) summed_N_ += (state.t_s - last_->t_s) * (state.v_N + last_->v_N) / 2;
  last_ = state;
  VehicleState summed = state;
  summed.p_NB = summed_N_;
  history_.Add(summed);
}

bool MovingTarget::Correct(double t_s, const Eigen::Vector3d& p_CT, const Eigen::Matrix3d& covariance) {
  const auto state = history_.At(t_s);
  if (!state || (filter_ && t_s < filter_t_s_)) return false;
  const Pose X_NC = Pose{state->R_NB, state->p_NB} * X_BC_;
  const Eigen::Matrix3d R = X_NC.R.toRotationMatrix();
  const Eigen::Vector3d p_NT = X_NC * p_CT;
  const double tilt = Radians(options_.tilt_sigma_deg);
  const Eigen::Matrix3d lever = Skew(p_NT - X_NC.p);
  const Eigen::Matrix3d P = R * covariance * R.transpose() + tilt * tilt * lever * lever.transpose();
  if (filter_) {
    ConstantVelocityFilter predicted = *filter_;
    predicted.Predict(t_s - filter_t_s_);
    const Eigen::Vector3d off = p_NT - predicted.position();
    const Eigen::Matrix3d S = predicted.covariance().topLeftCorner<3, 3>() + P;
    if (off.dot(S.ldlt().solve(off)) > kOdd * kOdd) {
      if (!odd_since_s_) odd_since_s_ = t_s;
      if (t_s - *odd_since_s_ < kOdd_s) return false;
      filter_.reset();
    } else {
      predicted.Correct(p_NT, P);
      filter_ = predicted;
    }
  }
  if (!filter_) {
    measurements_ = 0;
    filter_.emplace(p_NT, std::sqrt(P.trace()), Eigen::Vector3d::Zero(), kFirstSpeed_m_s,
                    options_.acceleration_m_s2);
  }
  ++measurements_;
  odd_since_s_.reset();
  filter_t_s_ = t_s;
  return true;
}

std::optional<Eigen::Vector3d> MovingTarget::InCamera(double t_s, double most_age_s) const {
  if (!filter_ || t_s < filter_t_s_ || t_s - filter_t_s_ > most_age_s) return std::nullopt;
  const auto state = history_.At(t_s);
  if (!state) return std::nullopt;
  const Pose X_NC = Pose{state->R_NB, state->p_NB} * X_BC_;
  return X_NC.Inverse() * Eigen::Vector3d(filter_->position() + (t_s - filter_t_s_) * filter_->velocity());
}

std::optional<MovingTarget::Estimate> MovingTarget::At(double t_s) const {
  if (!filter_) return std::nullopt;
  const double age_s = t_s - filter_t_s_;
  const Eigen::Matrix3d v_covariance = filter_->covariance().bottomRightCorner<3, 3>();
  return Estimate{filter_->position() + age_s * filter_->velocity() + last_->p_NB - summed_N_,
                  filter_->velocity(), std::sqrt(v_covariance.diagonal().maxCoeff()), age_s, measurements_};
}

Eigen::Vector3d LevelAhead(const Eigen::Vector3d& p_NT, const Eigen::Vector3d& p_N, double yaw) {
  const Eigen::Vector3d p_H = HeadingRotation(yaw).conjugate() * (p_NT - p_N);
  return {p_H.y(), p_H.z(), p_H.x()};
}

}  // namespace kestrel::control
