// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace kestrel {

// X_AB: the pose of frame B in frame A. Adjacent letters must match: X_AC = X_AB * X_BC, p_AQ = X_AB * p_BQ.
// Frames: N local north-east-down world, B body forward-right-down, H heading frame (N turned by yaw only),
// C camera optical (x right, y down, z forward), T target or pad.
struct Pose {
  Eigen::Quaterniond R = Eigen::Quaterniond::Identity();  // R_AB turns vectors of B into A
  Eigen::Vector3d p = Eigen::Vector3d::Zero();            // p_AB, m

  Pose Inverse() const {
    const Eigen::Quaterniond inv = R.conjugate();
    return {inv, -(inv * p)};
  }
};

inline Pose operator*(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R * X_BC.R, X_AB.R * X_BC.p + X_AB.p};
}
inline Eigen::Vector3d operator*(const Pose& X_AB, const Eigen::Vector3d& p_BQ) {
  return X_AB.R * p_BQ + X_AB.p;
}

// [v]x, so that Skew(a) * b = a x b.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The rotation about v by |v| rad, and its inverse: the vector (axis times angle, angle in [0, pi]) of a
// rotation.
Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& v_rad);
Eigen::Vector3d LogRotation(const Eigen::Quaterniond& R);

}  // namespace kestrel
