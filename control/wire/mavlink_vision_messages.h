// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "control/wire/mavlink_fields.h"

// The messages in which a companion tells an autopilot what its camera sees, as control/wire/mavlink_messages.h has
// the others: the aircraft's pose, and the place to land on.
namespace kestrel::control::wire::mavlink {

struct VisionPositionEstimate {
  static constexpr std::uint32_t kId = 102;
  static constexpr std::uint8_t kCrcExtra = 158;
  std::uint64_t usec = 0;
  float x = 0, y = 0, z = 0;           // m, in N
  float roll = 0, pitch = 0, yaw = 0;  // rad
  // Since version 2:
  std::array<float, 21> covariance{};  // upper triangle, by rows; first NaN: unknown
  std::uint8_t reset_counter = 0;
  bool operator==(const VisionPositionEstimate&) const = default;
};
template <class Visitor, Either<VisionPositionEstimate> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.usec, m.x, m.y, m.z, m.roll, m.pitch, m.yaw);
  v.Extensions(m.covariance, m.reset_counter);
}

struct LandingTarget {
  static constexpr std::uint32_t kId = 149;
  static constexpr std::uint8_t kCrcExtra = 200;
  std::uint64_t time_usec = 0;
  float angle_x = 0, angle_y = 0;  // rad, from the axis of the camera
  float distance = 0;              // m
  float size_x = 0, size_y = 0;    // rad
  std::uint8_t target_num = 0;
  std::uint8_t frame = 0;  // MAV_FRAME
  // Since version 2:
  float x = 0, y = 0, z = 0;        // m, in frame
  std::array<float, 4> q{};         // w, x, y, z
  std::uint8_t type = 0;            // LANDING_TARGET_TYPE
  std::uint8_t position_valid = 0;  // 1: x, y, z are
  bool operator==(const LandingTarget&) const = default;
};
template <class Visitor, Either<LandingTarget> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.angle_x, m.angle_y, m.distance, m.size_x, m.size_y, m.target_num, m.frame);
  v.Extensions(m.x, m.y, m.z, m.q, m.type, m.position_valid);
}

struct Odometry {
  static constexpr std::uint32_t kId = 331;
  static constexpr std::uint8_t kCrcExtra = 91;
  std::uint64_t time_usec = 0;
  float x = 0;  // m, in frame_id
  float y = 0;
  float z = 0;
  std::array<float, 4> q{};  // of B in frame_id: w, x, y, z
  float vx = 0;              // m/s, in child_frame_id
  float vy = 0;
  float vz = 0;
  float rollspeed = 0;  // rad/s, in child_frame_id
  float pitchspeed = 0;
  float yawspeed = 0;
  std::array<float, 21>
      pose_covariance{};  // upper triangle by rows, of x, y, z, roll, pitch, yaw; first NaN: unknown
  std::array<float, 21> velocity_covariance{};  // the same of the velocities
  std::uint8_t frame_id = 0;                    // MAV_FRAME
  std::uint8_t child_frame_id = 0;              // MAV_FRAME
  // Since version 2:
  std::uint8_t reset_counter = 0;   // changes where the pose jumps
  std::uint8_t estimator_type = 0;  // MAV_ESTIMATOR_TYPE
  std::int8_t quality = 0;          // percent; 0: unknown, -1: failed
  bool operator==(const Odometry&) const = default;
};
template <class Visitor, Either<Odometry> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.x, m.y, m.z, m.q, m.vx, m.vy, m.vz, m.rollspeed, m.pitchspeed, m.yawspeed,
    m.pose_covariance, m.velocity_covariance, m.frame_id, m.child_frame_id);
  v.Extensions(m.reset_counter, m.estimator_type, m.quality);
}

// PX4's own, of its "development" set. Its target estimator takes the place of LandingTarget.
struct TargetRelative {
  static constexpr std::uint32_t kId = 511;
  static constexpr std::uint8_t kCrcExtra = 28;
  std::uint64_t timestamp = 0;  // us
  float x = 0;                  // m, from the aircraft, in frame
  float y = 0;
  float z = 0;
  std::array<float, 3> pos_std{};   // m
  float yaw_std = 0;                // rad
  std::array<float, 4> q_target{};  // of the target in frame: w, x, y, z
  std::array<float, 4> q_sensor{};  // of the sensor in B; zeros: none told
  std::uint8_t id = 0;
  std::uint8_t frame = 0;  // TARGET_OBS_FRAME
  std::uint8_t type = 0;   // LANDING_TARGET_TYPE
  bool operator==(const TargetRelative&) const = default;
};
template <class Visitor, Either<TargetRelative> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.timestamp, m.x, m.y, m.z, m.pos_std, m.yaw_std, m.q_target, m.q_sensor, m.id, m.frame, m.type);
}

}  // namespace kestrel::control::wire::mavlink
