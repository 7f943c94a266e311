// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "geometry/pose.h"

// The only place that knows MuJoCo's frames. M is MuJoCo's world, read as north-west-up; F is a MuJoCo body,
// forward- left-up; G is a MuJoCo camera, looking along -z with y up. M and N, and F and B, differ by (x, -y,
// -z): half a turn about x, its own inverse.
namespace kestrel::sim {

inline Eigen::Vector3d SwapNedNwu(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

// R_NB from R_MF and back: the axes of both sides are swapped.
inline Eigen::Quaterniond SwapNedNwu(const Eigen::Quaterniond& R) { return {R.w(), R.x(), -R.y(), -R.z()}; }

inline Eigen::Vector3d VectorFromMujoco(const double v_M[3]) {
  return SwapNedNwu(Eigen::Vector3d(v_M[0], v_M[1], v_M[2]));
}

inline void VectorToMujoco(const Eigen::Vector3d& v_N, double v_M[3]) {
  Eigen::Map<Eigen::Vector3d>{v_M} = SwapNedNwu(v_N);
}

// Seven numbers of a free joint: position, then quaternion w x y z.
inline Pose PoseFromMujoco(const double qpos[7]) {
  return {SwapNedNwu(Eigen::Quaterniond(qpos[3], qpos[4], qpos[5], qpos[6])), VectorFromMujoco(qpos)};
}

inline void PoseToMujoco(const Pose& X_NB, double qpos[7]) {
  VectorToMujoco(X_NB.p, qpos);
  const Eigen::Quaterniond R_MF = SwapNedNwu(X_NB.R);
  qpos[3] = R_MF.w(), qpos[4] = R_MF.x(), qpos[5] = R_MF.y(), qpos[6] = R_MF.z();
}

}  // namespace kestrel::sim
