// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <utility>

#include "base/yaml/fields.h"

namespace kestrel::control {

struct HoverObserverOptions {
  double position_sigma_m = 0.01;
  double acceleration_m_s2 = 0.4;
  double disturbance_m_s3 = 0.6;
};

inline void Fields(FieldVisitor& v, HoverObserverOptions& o) {
  v({"position_sigma_m", "standard deviation of an offset that the camera measures"}, o.position_sigma_m,
    1e-4, 1.0);
  v({"acceleration_m_s2", "noise of the acceleration that thrust and attitude give, per root hertz"},
    o.acceleration_m_s2, 0.001, 20.0);
  v({"disturbance_m_s3",
     "random walk of the acceleration by wind and by errors of the model, per root hertz"},
    o.disturbance_m_s3, 0.001, 20.0);
}

// Offset, velocity and disturbing acceleration of an aircraft by late measurements of the offset alone and the
// acceleration that its thrust gives: a Kalman filter of each axis of N by itself. It stands at the time of the
// last measurement, which is an exposure, and is carried on from there by the accelerations since.
class HoverObserver {
 public:
  struct Estimate {
    Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // m
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
    Eigen::Vector3d d_N = Eigen::Vector3d::Zero();  // m/s^2
    double age_s = 0;                               // since the last measurement
  };

  explicit HoverObserver(const HoverObserverOptions& options) : options_(options) {}

  // From this time on, until the next; times must not go back.
  void AddAcceleration(double t_s, const Eigen::Vector3d& a_N);
  // Later than the one before. After a gap of a second it begins anew.
  void Correct(double t_s, const Eigen::Vector3d& p_N);
  // None: nothing measured yet.
  std::optional<Estimate> At(double t_s) const;
  void Forget() { t_s_.reset(); }

 private:
  struct State {
    Eigen::Vector3d p, v, d;
  };
  State Carried(State state, double from_s, double to_s) const;

  HoverObserverOptions options_;
  std::deque<std::pair<double, Eigen::Vector3d>> accelerations_;
  std::optional<double> t_s_;
  State state_;
  Eigen::Matrix3d P_;  // of p, v, d of any axis
};

}  // namespace kestrel::control
