// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/deck/deck_estimator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kLongestStep_s = 0.1;
constexpr double kDrift_m_s2 = 0.05;  // of the mean height's rate, per root hertz
constexpr double kYaw_rad_s2 = 0.3;   // of the heading's rate, per root hertz
constexpr double kYawSigma = 0.03;    // rad, of a fix
constexpr double kNewSpeed_m_s = 3;   // standard deviation of a deck's speed that was seen once
constexpr int kRefusalsToBelieve = 6;

Eigen::Matrix2d WhiteNoise(double density, double dt) {
  const double q = density * density;
  Eigen::Matrix2d Q;
  Q << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
  return q * Q;
}

// Singer's model: the transition is exact, the noise that of a white jerk, for steps that are short to the time.
struct Singer {
  double sigma, time_s;

  Eigen::Matrix3d Transition(double dt) const {
    const double e = std::exp(-dt / time_s);
    Eigen::Matrix3d F;
    F << 1, dt, time_s * (dt - time_s * (1 - e)), 0, 1, time_s * (1 - e), 0, 0, e;
    return F;
  }
  Eigen::Matrix3d Noise(double dt) const {
    const double q = 2 * sigma * sigma / time_s, d2 = dt * dt, d3 = d2 * dt;
    Eigen::Matrix3d Q;
    Q << d3 * d2 / 20, d2 * d2 / 8, d3 / 6, d2 * d2 / 8, d3 / 3, d2 / 2, d3 / 6, d2 / 2, dt;
    return q * Q;
  }
};

Oscillator HeaveOf(const DeckEstimatorOptions& o) {
  return {2 * std::numbers::pi / o.heave_period_s, o.damping, o.heave_m};
}
Oscillator TiltOf(const DeckEstimatorOptions& o) {
  return {2 * std::numbers::pi / o.tilt_period_s, o.damping, Radians(o.tilt_deg)};
}

}  // namespace

void DeckEstimator::Filters::Predict(double dt_s, const DeckEstimatorOptions& options) {
  const Singer singer{options.acceleration_m_s2, options.acceleration_s};
  const Oscillator heave = HeaveOf(options), swing = TiltOf(options);
  for (double left = dt_s; left > 1e-9; left -= kLongestStep_s) {
    const double dt = std::min(left, kLongestStep_s);
    for (Kalman<3>& axis : level) axis.Predict(singer.Transition(dt), singer.Noise(dt));
    Eigen::Matrix4d F = Eigen::Matrix4d::Identity(), Q = Eigen::Matrix4d::Zero();
    F(0, 1) = dt;
    F.bottomRightCorner<2, 2>() = heave.Transition(dt);
    Q.topLeftCorner<2, 2>() = WhiteNoise(kDrift_m_s2, dt);
    Q.bottomRightCorner<2, 2>() = heave.Noise(dt);
    height.Predict(F, Q);
    for (Kalman<2>& axis : tilt) axis.Predict(swing.Transition(dt), swing.Noise(dt));
    Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
    turn(0, 1) = dt;
    yaw.Predict(turn, WhiteNoise(kYaw_rad_s2, dt));
  }
}

DeckEstimator::DeckEstimator(const Pose& X_BC, const DeckEstimatorOptions& options)
    : X_BC_(X_BC), options_(options) {}

void DeckEstimator::AddState(const VehicleState& state) {
  VehicleState in_O = state;
  in_O.p_NB = last_ ? Eigen::Vector3d(last_->p_NB + (state.t_s - last_->t_s) * (state.v_N + last_->v_N) / 2)
                    : Eigen::Vector3d(state.p_NB);
  history_.Add(in_O);
  last_ = in_O;
}

void DeckEstimator::Begin(const Pose& X_OT) {
  const double place = options_.position_sigma_m * options_.position_sigma_m;
  for (int i = 0; i < 2; ++i) {
    Kalman<3>& axis = filters_.level[i];
    axis.x << X_OT.p[i], 0, 0;
    axis.P = Eigen::Vector3d(place, kNewSpeed_m_s * kNewSpeed_m_s,
                             options_.acceleration_m_s2 * options_.acceleration_m_s2)
                 .asDiagonal();
    filters_.tilt[i].x.setZero();
    filters_.tilt[i].P = TiltOf(options_).Stationary();
  }
  filters_.height.x << X_OT.p.z(), 0, 0, 0;
  filters_.height.P.setZero();
  const double heave = options_.heave_m * options_.heave_m;
  filters_.height.P.topLeftCorner<2, 2>() = Eigen::Vector2d(place + heave, 0.04).asDiagonal();
  filters_.height.P.bottomRightCorner<2, 2>() = HeaveOf(options_).Stationary();
  filters_.yaw.x << YawOf(X_OT.R), 0;
  filters_.yaw.P = Eigen::Vector2d(kYawSigma * kYawSigma, 0.1).asDiagonal();
}

std::optional<DeckEstimator::Deck> DeckEstimator::At(double t_s) const {
  if (!seen_) return std::nullopt;
  Filters f = filters_;
  f.Predict(std::max(0.0, t_s - t_s_), options_);
  const Oscillator heave = HeaveOf(options_);
  Deck deck;
  for (int i = 0; i < 2; ++i) {
    deck.p_OT[i] = f.level[i].x[0], deck.v_N[i] = f.level[i].x[1], deck.a_N[i] = f.level[i].x[2];
    deck.normal_N[i] = f.tilt[i].x[0];
  }
  const Eigen::Vector4d& z = f.height.x;
  deck.p_OT.z() = z[0] + z[2], deck.v_N.z() = z[1] + z[3];
  deck.a_N.z() = -heave.w * heave.w * z[2] - 2 * heave.damping * heave.w * z[3];
  deck.normal_N.normalize();
  deck.yaw = WrapAngle(f.yaw.x[0]), deck.yaw_rate = f.yaw.x[1];
  deck.sigma_m = std::sqrt(std::max(f.level[0].P(0, 0), f.level[1].P(0, 0)));
  deck.age_s = t_s - fixed_s_;
  return deck;
}

std::optional<Pose> DeckEstimator::ExpectedPose(double t_s) const {
  const auto deck = At(t_s);
  const auto state = history_.At(t_s);
  if (!deck || !state) return std::nullopt;
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), deck->normal_N);
  const Pose X_OT{tilt * HeadingRotation(deck->yaw), deck->p_OT};
  return (Pose{state->R_NB, state->p_NB} * X_BC_).Inverse() * X_OT;
}

std::optional<Pose> DeckEstimator::Correct(double t_s, const Pose& X_CT,
                                           const Eigen::Matrix<double, 6, 6>& covariance) {
  const auto state = history_.At(t_s);
  if (!state) return std::nullopt;
  const Pose X_OC = Pose{state->R_NB, state->p_NB} * X_BC_;
  const Pose X_OT = X_OC * X_CT;
  const Eigen::Matrix3d R_OC = X_OC.R.toRotationMatrix();
  const Eigen::Matrix3d place = R_OC * covariance.topLeftCorner<3, 3>() * R_OC.transpose();
  const Eigen::Matrix3d turn = R_OC * covariance.bottomRightCorner<3, 3>() * R_OC.transpose();
  const double fix = options_.position_sigma_m * options_.position_sigma_m;
  const double tilt = std::pow(Radians(options_.tilt_sigma_deg), 2);

  if (seen_ && t_s > t_s_) filters_.Predict(t_s - t_s_, options_);
  if (seen_) {
    const Eigen::Vector3d off(X_OT.p.x() - filters_.level[0].x[0], X_OT.p.y() - filters_.level[1].x[0],
                              X_OT.p.z() - filters_.height.x[0] - filters_.height.x[2]);
    const Eigen::Vector3d variance(filters_.level[0].P(0, 0), filters_.level[1].P(0, 0),
                                   filters_.height.P(0, 0) + filters_.height.P(2, 2));
    const double limit = 0.3 + 0.1 * std::abs(X_CT.p.z()) + 4 * std::sqrt(variance.sum());
    t_s_ = t_s;
    if (off.norm() > limit) {
      if (++refused_ < kRefusalsToBelieve) return std::nullopt;
      seen_ = false;
    }
  }
  refused_ = 0;
  if (!seen_) Begin(X_OT);
  seen_ = true;
  t_s_ = fixed_s_ = t_s;

  const Eigen::Vector3d normal_N = X_OT.R * Eigen::Vector3d::UnitZ();
  for (int i = 0; i < 2; ++i) {
    filters_.level[i].Correct({1, 0, 0}, X_OT.p[i], place(i, i) + fix);
    filters_.tilt[i].Correct({1, 0}, normal_N[i], turn(1 - i, 1 - i) + tilt);
  }
  filters_.height.Correct({1, 0, 1, 0}, X_OT.p.z(), place(2, 2) + fix);
  const double yaw = filters_.yaw.x[0] + WrapAngle(YawOf(X_OT.R) - filters_.yaw.x[0]);
  filters_.yaw.Correct({1, 0}, yaw, turn(2, 2) + kYawSigma * kYawSigma);
  return (X_OT.Inverse() * Pose{state->R_NB, state->p_NB});
}

}  // namespace kestrel::control
