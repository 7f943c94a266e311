// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "flight/dataset/trajectory/cubic_spline.h"
#include "geometry/pose.h"

namespace kestrel::flight {

// The motion of the aircraft at an instant.
struct Motion {
  Pose X_NB;
  Eigen::Vector3d v_N, a_N;  // m/s, m/s^2
  Eigen::Vector3d w_B;       // rad/s

  Eigen::Vector3d SpecificForce_B() const;  // m/s^2; at rest and level (0, 0, -g)
};

// A motion as a function of time: position by a cubic spline, so that velocity and acceleration are
// continuous. Stamps are ns; before the first and after the last it stands there.
class Trajectory {
 public:
  // Attitude by splines of yaw, pitch and roll, rad, without jumps of a turn. along: the yaw is that of
  // the velocity instead, where the aircraft moves horizontally.
  Trajectory(std::vector<std::int64_t> stamps_ns, const std::vector<Eigen::Vector3d>& p_N,
             const std::vector<Eigen::Vector3d>& yaw_pitch_roll, bool along);
  // Attitude from one to the next at an even rate about one axis (slerp).
  Trajectory(std::vector<std::int64_t> stamps_ns, const std::vector<Pose>& X_NB);

  std::int64_t begin_ns() const { return stamps_ns_.front(); }
  std::int64_t end_ns() const { return stamps_ns_.back(); }
  Motion At(std::int64_t t_ns) const;

 private:
  double Since_s(std::int64_t t_ns) const { return static_cast<double>(t_ns - stamps_ns_.front()) * 1e-9; }
  void TurnByAngles(double t_s, Motion& motion) const;
  void TurnBySlerp(std::int64_t t_ns, Motion& motion) const;

  std::vector<std::int64_t> stamps_ns_;
  CubicSpline position_, angles_;
  bool along_ = false;
  std::vector<Eigen::Quaterniond> turns_;  // empty: by angles_
};

}  // namespace kestrel::flight
