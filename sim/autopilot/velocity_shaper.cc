// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/velocity_shaper.h"

#include <algorithm>
#include <cmath>

namespace kestrel::sim {
namespace {

template <int N>
Eigen::Matrix<double, N, 1> NoLonger(const Eigen::Matrix<double, N, 1>& v, double limit) {
  const double norm = v.norm();
  if (norm > limit) return v * (limit / norm);
  return v;
}

}  // namespace

template <int N>
void VelocityShaper<N>::Reset(const Vector& velocity) {
  now_ = {velocity, Vector::Zero()};
  asked_.clear();
}

template <int N>
typename VelocityShaper<N>::Vector VelocityShaper<N>::Late(double t_s, const Vector& asked, double delay_s) {
  if (delay_s <= 0) return asked;
  asked_.emplace_back(t_s, asked);
  // The newest of those that are old enough stays in front; while none is, it is the oldest.
  while (asked_.size() > 1 && asked_[1].first <= t_s - delay_s) asked_.pop_front();
  return asked_.front().second;
}

template <int N>
typename VelocityShaper<N>::Shaped VelocityShaper<N>::Step(double t_s, double dt_s, const Vector& asked,
                                                           const ShaperLimits& limits) {
  const Vector wanted = Late(t_s, asked, limits.delay_s);
  const double most = limits.acceleration_m_s2, jerk = limits.jerk_m_s3;
  if (most <= 0) return now_ = {wanted, Vector::Zero()};
  const Vector error = wanted - now_.velocity;
  if (jerk <= 0) {
    const Vector step = NoLonger<N>(error, most * dt_s);
    return now_ = {now_.velocity + step, step / dt_s};
  }
  // The acceleration that the jerk can take back to nothing by the time the error is gone, a^2 / (2 j) = e;
  // near the goal proportional to the error, by the slope that the two limits make, so that it does not
  // chatter.
  const double off = error.norm();
  const double brake = std::min({std::sqrt(2 * jerk * off), jerk / most * off, most});
  const Vector towards = off > 0 ? Vector(brake / off * error) : Vector(Vector::Zero());
  const Vector acceleration = now_.acceleration + NoLonger<N>(towards - now_.acceleration, jerk * dt_s);
  return now_ = {now_.velocity + dt_s * acceleration, acceleration};
}

template class VelocityShaper<1>;
template class VelocityShaper<2>;

}  // namespace kestrel::sim
