// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/ground_camera.h"

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

Pose MastPose(const GroundPlace& place) {
  const TaitBryan angles{
      .yaw = Radians(place.yaw_deg), .pitch = Radians(place.pitch_deg), .roll = Radians(place.roll_deg)};
  return {Eigen::Quaterniond(RotationFromTaitBryan(angles)),
          {place.position_m.x(), place.position_m.y(), -place.position_m.z()}};
}

Eigen::Quaterniond HeadRotation(const PanTilt& at) {
  Eigen::Matrix3d R_axis;  // of a camera that looks along x
  R_axis << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return Eigen::Quaterniond(RotationFromTaitBryan({.yaw = at.pan, .pitch = at.tilt, .roll = 0}) * R_axis);
}

Pose CameraPose(const Pose& X_TG, const PanTilt& at) { return {X_TG.R * HeadRotation(at), X_TG.p}; }

PanTilt LookAt(const Pose& X_TG, const Eigen::Vector3d& p_T, const PanTilt& now) {
  constexpr double kAlongAxis = 1e-9;
  const Eigen::Vector3d ray_G = X_TG.R.conjugate() * (p_T - X_TG.p);
  const double level = ray_G.head<2>().norm();
  if (!(ray_G.norm() > 0)) return now;
  return {level > kAlongAxis * ray_G.norm() ? std::atan2(ray_G.y(), ray_G.x()) : now.pan,
          std::atan2(-ray_G.z(), level)};
}

}  // namespace kestrel::vision
