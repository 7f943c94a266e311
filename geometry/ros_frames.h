// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/pose.h"

// Our frames and those of ROS (REP 103, REP 105), in one place. ROS has the world east-north-up and bodies
// forward-left-up; here the world N is north-east-down and the body B forward-right-down. Cameras are the
// same: ROS's optical frames are x right, y down, z forward, as C. Each function is its own inverse.
namespace kestrel {

// Of a vector: north-east-down to east-north-up, and back.
inline Eigen::Vector3d WorldToRos(const Eigen::Vector3d& v) { return {v.y(), v.x(), -v.z()}; }

// Of a vector: forward-right-down to forward-left-up, and back. Also of the heading frame and the pad's.
inline Eigen::Vector3d BodyToRos(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

// Of the rotation of a body in the world: both change their axes. A half turn each: about (1, 1, 0) the
// world's, about x the body's.
inline Eigen::Quaterniond WorldBodyToRos(const Eigen::Quaterniond& R) {
  static const Eigen::Quaterniond kWorld(0, std::sqrt(0.5), std::sqrt(0.5), 0), kBody(0, 1, 0, 0);
  return kWorld * R * kBody;
}

// Of the rotation of a body in a frame that is itself a body's: the aircraft's in the pad's.
inline Eigen::Quaterniond BodyBodyToRos(const Eigen::Quaterniond& R) {
  static const Eigen::Quaterniond kBody(0, 1, 0, 0);
  return kBody * R * kBody.conjugate();
}

// Of a camera, or anything else of which the axes stay, in a body's frame.
inline Eigen::Quaterniond BodyCameraToRos(const Eigen::Quaterniond& R) {
  static const Eigen::Quaterniond kBody(0, 1, 0, 0);
  return kBody * R;
}

inline Pose WorldBodyToRos(const Pose& X) { return {WorldBodyToRos(X.R), WorldToRos(X.p)}; }
inline Pose BodyBodyToRos(const Pose& X) { return {BodyBodyToRos(X.R), BodyToRos(X.p)}; }
inline Pose BodyCameraToRos(const Pose& X) { return {BodyCameraToRos(X.R), BodyToRos(X.p)}; }

}  // namespace kestrel
