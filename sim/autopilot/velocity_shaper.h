// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <utility>

namespace kestrel::sim {

struct ShaperLimits {
  double delay_s = 0;
  double acceleration_m_s2 = 0;  // 0: no limit
  double jerk_m_s3 = 0;          // 0: no limit; of use with a limit of the acceleration alone
};

// How an autopilot shapes a velocity of N axes that it is asked for, m/s, before it follows it: after a dead
// time, then by no more than an acceleration, which itself changes by no more than a jerk.
template <int N>
class VelocityShaper {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  struct Shaped {
    Vector velocity = Vector::Zero();      // m/s
    Vector acceleration = Vector::Zero();  // m/s^2, with which it changes; 0 without a limit of it
  };

  // t_s: of the step's end, in rising order.
  Shaped Step(double t_s, double dt_s, const Vector& asked, const ShaperLimits& limits);
  // It is there already, with nothing asked for in the past.
  void Reset(const Vector& velocity);

 private:
  Vector Late(double t_s, const Vector& asked, double delay_s);

  Shaped now_;
  std::deque<std::pair<double, Vector>> asked_;  // s, m/s: those of the last delay_s
};

extern template class VelocityShaper<1>;
extern template class VelocityShaper<2>;

}  // namespace kestrel::sim
