// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

std::vector<double> Seconds(const std::vector<std::int64_t>& stamps_ns) {
  std::vector<double> seconds;
  for (const std::int64_t stamp : stamps_ns)
    seconds.push_back(static_cast<double>(stamp - stamps_ns.front()) * 1e-9);
  return seconds;
}

std::vector<Eigen::Vector3d> PlacesOf(const std::vector<Pose>& poses) {
  std::vector<Eigen::Vector3d> places;
  for (const Pose& pose : poses) places.push_back(pose.p);
  return places;
}

}  // namespace

Eigen::Vector3d Motion::SpecificForce_B() const {
  return X_NB.R.conjugate() * (a_N - Eigen::Vector3d(0, 0, kGravity_m_s2));
}

Trajectory::Trajectory(std::vector<std::int64_t> stamps_ns, const std::vector<Eigen::Vector3d>& p_N,
                       const std::vector<Eigen::Vector3d>& yaw_pitch_roll, bool along)
    : stamps_ns_(std::move(stamps_ns)),
      position_(Seconds(stamps_ns_), p_N),
      angles_(Seconds(stamps_ns_), yaw_pitch_roll),
      along_(along) {}

Trajectory::Trajectory(std::vector<std::int64_t> stamps_ns, const std::vector<Pose>& X_NB)
    : stamps_ns_(std::move(stamps_ns)), position_(Seconds(stamps_ns_), PlacesOf(X_NB)) {
  for (const Pose& pose : X_NB) turns_.push_back(pose.R.normalized());
}

Motion Trajectory::At(std::int64_t t_ns) const {
  t_ns = std::clamp(t_ns, begin_ns(), end_ns());
  const CubicSpline::Point p = position_.At(Since_s(t_ns));
  Motion motion{{Eigen::Quaterniond::Identity(), p.value}, p.first, p.second, Eigen::Vector3d::Zero()};
  if (turns_.empty())
    TurnByAngles(Since_s(t_ns), motion);
  else
    TurnBySlerp(t_ns, motion);
  return motion;
}

void Trajectory::TurnByAngles(double t_s, Motion& motion) const {
  const CubicSpline::Point angles = angles_.At(t_s);
  double yaw = angles.value.x(), yaw_rate = angles.first.x();
  if (along_) {
    const auto &v = motion.v_N, &a = motion.a_N;
    yaw = std::atan2(v.y(), v.x());
    yaw_rate = (v.x() * a.y() - v.y() * a.x()) / v.head<2>().squaredNorm();
  }
  const double pitch = angles.value.y(), roll = angles.value.z();
  motion.X_NB.R = Eigen::Quaterniond(RotationFromTaitBryan({yaw, pitch, roll}));
  // The rates of the three angles, each about its axis, in B.
  const double pitch_rate = angles.first.y(), roll_rate = angles.first.z();
  motion.w_B = {roll_rate - yaw_rate * std::sin(pitch),
                pitch_rate * std::cos(roll) + yaw_rate * std::cos(pitch) * std::sin(roll),
                -pitch_rate * std::sin(roll) + yaw_rate * std::cos(pitch) * std::cos(roll)};
}

void Trajectory::TurnBySlerp(std::int64_t t_ns, Motion& motion) const {
  const auto next = std::upper_bound(stamps_ns_.begin() + 1, stamps_ns_.end() - 1, t_ns);
  const auto i = static_cast<std::size_t>(next - stamps_ns_.begin());
  const double length_s = static_cast<double>(stamps_ns_[i] - stamps_ns_[i - 1]) * 1e-9;
  const double since_s = static_cast<double>(t_ns - stamps_ns_[i - 1]) * 1e-9;
  const Eigen::Vector3d turn = LogRotation(turns_[i - 1].conjugate() * turns_[i]);
  motion.w_B = turn / length_s;
  motion.X_NB.R = turns_[i - 1] * ExpRotation(motion.w_B * since_s);
}

}  // namespace kestrel::flight
