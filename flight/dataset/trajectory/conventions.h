// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "geometry/pose.h"

// Frames and stamps of the data sets that are written and of the trajectories that are read.
//
// W, the world of all formats: x north, y west, z up, its origin that of N. It is N turned by half a turn
// about x.
//
// - EuRoC: p_RS_R, q_RS and v_RS_R are of the body B (S is B, R is W); q_RS turns vectors of B into W and is
//   written w x y z. B is forward, right, down; so is the IMU, in B's origin, unless the scenario's
//   instruments.imu says otherwise: at rest and level its accelerometer says (0, 0, -g). T_BS of the IMU is
//   X_BI. T_BS of a camera is X_BC, of its optical axes: x right, y down, z forward. Stamps are integers of ns.
// - TUM: groundtruth.txt is of the camera's optical axes in W: tx ty tz qx qy qz qw. The accelerometer is the
//   IMU's. Stamps are s with nine decimals. The depth is that of the plane, along the optical axis, 5000 to the
//   metre; 0: none, or beyond 13.1 m.
// - KITTI: poses/NN.txt are the first three rows of X_C0Ck, of camera 0 at frame k in camera 0 at the first
//   frame. Tr of calib.txt is X_CB, as there is no lidar. times.txt is s since the first frame. The depth is
//   that of the plane, 256 to the metre; 0: none, or beyond 255.9 m. The flow is that of KITTI's devkit: 64 to
//   the pixel about 32768, and whether it is known.
// - Kalibr: T_cam_imu of camchain.yaml is X_CI. Camera and IMU have one clock: timeshift_cam_imu is 0.
namespace kestrel::flight {

// X_WA of X_NA, and X_NA of X_WA.
inline Pose TurnWorld(const Pose& X) {
  const Eigen::Quaterniond half_turn(0, 1, 0, 0);
  return {half_turn * X.R, half_turn * X.p};
}
inline Eigen::Vector3d TurnWorld(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

// The stamp of time 0 of a flight, and of a way that a file gives with times of its own: late enough that
// all names of a set have as many digits, and early enough that a double holds each ns.
inline constexpr std::int64_t kBegin_ns = 1'000'000'000'000;

}  // namespace kestrel::flight
