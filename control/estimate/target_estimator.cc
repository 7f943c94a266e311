// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/target_estimator.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kYawTime_s = 1.0;
constexpr double kLongestPrediction_s = 3.0;
constexpr int kRefusalsToBelieve = 6;

}  // namespace

TargetEstimator::TargetEstimator(const Pose& X_BC, const TargetEstimatorOptions& options)
    : X_BC_(X_BC), options_(options), tilt_(TiltAlignment::Options{}) {}

void TargetEstimator::AddState(const VehicleState& state) { history_.Add(state); }

std::optional<TargetEstimator::Estimate> TargetEstimator::At(double t_s) const {
  const auto state = history_.At(t_s);
  if (!filter_ || !state) return std::nullopt;
  const Eigen::Quaterniond R_TN = HeadingRotation(-yaw_NT_);
  Estimate e;
  e.age_s = t_s - filter_t_s_;
  e.velocity_error_T = velocity_error_T_;
  e.v_T = R_TN * state->v_N - velocity_error_T_;
  e.yaw_TB = WrapAngle(YawOf(state->R_NB) - yaw_NT_);
  // The filter's velocity, and what the autopilot has felt since: not its position, which jumps when GPS
  // corrects it.
  Eigen::Vector3d v_T = filter_->velocity();
  if (const auto then = history_.At(filter_t_s_)) v_T += R_TN * (state->v_N - then->v_N) / 2;
  e.p_TB = filter_->position() + v_T * e.age_s;
  return e;
}

std::optional<Pose> TargetEstimator::ExpectedPose(double t_s) const {
  const auto estimate = At(t_s);
  const auto state = history_.At(t_s);
  if (!estimate || !state || estimate->age_s > kLongestPrediction_s) return std::nullopt;
  const Pose X_TB{HeadingRotation(-yaw_NT_) * state->R_NB, estimate->p_TB};
  Pose X_CT = (X_TB * X_BC_).Inverse();
  if (options_.tilt_alignment) {
    const Eigen::Vector3d down_C = X_CT.R * Eigen::Vector3d::UnitZ();
    // Turn the camera about itself: the aircraft's place stays.
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(down_C, tilt_.Apply(down_C));
    X_CT = {turn * X_CT.R, turn * X_CT.p};
  }
  return X_CT;
}

std::optional<Pose> TargetEstimator::Correct(double t_s, const Pose& X_CT_seen,
                                             const Eigen::Matrix<double, 6, 6>& covariance_seen) {
  const auto state = history_.At(t_s);
  if (!state) return std::nullopt;
  Pose X_CT = X_CT_seen;
  Eigen::Matrix<double, 6, 6> covariance = covariance_seen;
  const double dt = filter_ ? t_s - filter_t_s_ : 0;
  if (options_.tilt_alignment) {
    const Eigen::Vector3d down_C = X_BC_.R.conjugate() * (state->R_NB.conjugate() * Eigen::Vector3d::UnitZ());
    tilt_.Predict(dt);
    // The offset learns from vision alone, before vision is mended by it: nothing is counted twice in one
    // frame.
    const TiltAlignment before = tilt_;
    tilt_.Correct(dt, down_C, X_CT.R * Eigen::Vector3d::UnitZ(), covariance.bottomRightCorner<3, 3>());
    FuseNormal(before.Apply(down_C), before.sigma(), X_CT, covariance);
  }
  const Pose X_TB = (X_BC_ * X_CT).Inverse();

  // Position of B in T: -R^T t, so its error is that of t less that of the arm turned by the attitude's
  // error.
  Eigen::Matrix<double, 3, 6> J;
  const Eigen::Matrix3d R_TC = X_CT.R.conjugate().toRotationMatrix();
  J << -R_TC, -R_TC * Skew(X_CT.p);
  Eigen::Matrix3d R = J * covariance * J.transpose();
  R.diagonal().array() += options_.position_sigma_m * options_.position_sigma_m;

  const double yaw_NT = WrapAngle(YawOf(state->R_NB) - YawOf(X_TB.R));
  if (filter_) {
    const auto expected = At(t_s);
    const double off = expected ? (X_TB.p - expected->p_TB).norm() : 0;
    const double limit =
        0.3 + 0.1 * std::abs(X_TB.p.z()) + std::min(0.5, 6 * std::sqrt(R.trace())) + 0.5 * dt;
    if (off > limit && ++refused_ < kRefusalsToBelieve) return std::nullopt;
    if (off > limit) filter_.reset();
  }
  refused_ = 0;
  const Eigen::Vector3d v_reported_T = HeadingRotation(-yaw_NT) * state->v_N;
  if (!filter_) {
    filter_.emplace(X_TB.p, std::sqrt(R.trace() / 3), v_reported_T - velocity_error_T_, 0.3,
                    options_.acceleration_m_s2);
    yaw_NT_ = yaw_NT;
  } else {
    filter_->Predict(dt);
    filter_->Correct(X_TB.p, R);
    yaw_NT_ = WrapAngle(yaw_NT_ + std::min(1.0, dt / kYawTime_s) * WrapAngle(yaw_NT - yaw_NT_));
    velocity_error_T_ += std::min(1.0, dt / options_.velocity_time_s) *
                         (v_reported_T - filter_->velocity() - velocity_error_T_);
  }
  filter_t_s_ = t_s;
  return X_TB;
}

void TargetEstimator::Forget() {
  filter_.reset();
  refused_ = 0;
}

}  // namespace kestrel::control
