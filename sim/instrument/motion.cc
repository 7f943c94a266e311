// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/motion.h"

namespace kestrel::sim {

Motion Between(const Truth& before, const Truth& after, double share) {
  const auto mix = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) -> Eigen::Vector3d {
    return (1 - share) * a + share * b;
  };
  const double dt_s = after.t_s - before.t_s;
  Motion motion;
  motion.X_NB = {before.X_NB.R.slerp(share, after.X_NB.R), mix(before.X_NB.p, after.X_NB.p)};
  motion.v_N = mix(before.v_N, after.v_N);
  motion.w_B = mix(before.w_B, after.w_B);
  motion.acceleration_N = (after.v_N - before.v_N) / dt_s;
  motion.w_rate_B = (after.w_B - before.w_B) / dt_s;
  return motion;
}

Eigen::Vector3d PointVelocity(const Motion& motion, const Eigen::Vector3d& p_B) {
  return motion.v_N + motion.X_NB.R * motion.w_B.cross(p_B);
}

Eigen::Vector3d PointAcceleration(const Motion& motion, const Eigen::Vector3d& p_B) {
  const Eigen::Vector3d& w_B = motion.w_B;
  return motion.acceleration_N + motion.X_NB.R * (motion.w_rate_B.cross(p_B) + w_B.cross(w_B.cross(p_B)));
}

}  // namespace kestrel::sim
