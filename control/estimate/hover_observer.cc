// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/hover_observer.h"

#include <algorithm>
#include <cmath>

namespace kestrel::control {
namespace {

constexpr double kMeasurementGap_s = 1;
constexpr double kVelocityAtFirst_m_s = 0.5, kDisturbanceAtFirst_m_s2 = 0.5;
constexpr double kKeptAccelerations_s = 3;  // of accelerations

}  // namespace

void HoverObserver::AddAcceleration(double t_s, const Eigen::Vector3d& a_N) {
  accelerations_.emplace_back(t_s, a_N);
  while (accelerations_.size() > 1 && accelerations_[1].first < t_s - kKeptAccelerations_s)
    accelerations_.pop_front();
}

HoverObserver::State HoverObserver::Carried(State s, double from_s, double to_s) const {
  const auto step = [&](double dt, const Eigen::Vector3d& a) {
    s.p += dt * s.v + dt * dt / 2 * (a + s.d);
    s.v += dt * (a + s.d);
  };
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  // before the first that is known
  double t = from_s;
  for (const auto& [since_s, next] : accelerations_) {
    if (since_s >= to_s) break;
    if (since_s > t) step(since_s - t, a), t = since_s;
    a = next;
  }
  step(to_s - t, a);
  return s;
}

void HoverObserver::Correct(double t_s, const Eigen::Vector3d& p_N) {
  const double R = options_.position_sigma_m * options_.position_sigma_m;
  const double dt = t_s_ ? t_s - *t_s_ : kMeasurementGap_s;
  if (!(dt > 0 && dt < kMeasurementGap_s)) {
    if (t_s_ && dt <= 0) return;
    state_ = {p_N, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    P_ = Eigen::Vector3d(R, std::pow(kVelocityAtFirst_m_s, 2), std::pow(kDisturbanceAtFirst_m_s2, 2))
             .asDiagonal();
    t_s_ = t_s;
    return;
  }
  state_ = Carried(state_, *t_s_, t_s);
  t_s_ = t_s;
  Eigen::Matrix3d F, Q;
  F << 1, dt, dt * dt / 2, 0, 1, dt, 0, 0, 1;
  const double qa = std::pow(options_.acceleration_m_s2, 2), qd = std::pow(options_.disturbance_m_s3, 2);
  Q << dt * dt * dt / 3, dt * dt / 2, 0, dt * dt / 2, dt, 0, 0, 0, 0;
  Q *= qa;
  Q(2, 2) = qd * dt;
  P_ = F * P_ * F.transpose() + Q;
  const Eigen::Vector3d k = P_.col(0) / (P_(0, 0) + R);
  const Eigen::Vector3d innovation = p_N - state_.p;
  state_.p += k[0] * innovation, state_.v += k[1] * innovation, state_.d += k[2] * innovation;
  P_ = (P_ - k * P_.row(0)).eval();
  P_ = ((P_ + P_.transpose()) / 2).eval();
}

std::optional<HoverObserver::Estimate> HoverObserver::At(double t_s) const {
  if (!t_s_) return std::nullopt;
  const State s = Carried(state_, *t_s_, std::max(t_s, *t_s_));
  return Estimate{s.p, s.v, s.d, t_s - *t_s_};
}

}  // namespace kestrel::control
