// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/camera_mount.h"

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

Pose MountPose(const CameraMount& mount) {
  Eigen::Matrix3d R_BD;  // D: looking down, the top of the image forward
  R_BD << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d turn =
      RotationFromTaitBryan({Radians(mount.yaw_deg), Radians(mount.pitch_deg), Radians(mount.roll_deg)});
  return {Eigen::Quaterniond(Eigen::Matrix3d(turn * R_BD)), mount.position_m};
}

}  // namespace kestrel::vision
