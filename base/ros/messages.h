// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

// The messages of ROS 2 that a flight's log is made of, by their published definitions (common_interfaces,
// geometry2, rcl_interfaces, mavros). Names and order are theirs; units are SI, and a quaternion turns
// vectors of the child's frame into the header's. kType finds the schema (schemas.h); Members names what is
// written (cdr.h).
namespace kestrel::ros {

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
template <class V>
void Members(V& v, Time& m) {
  v(m.sec, m.nanosec);
}

// Of a time since the epoch of its log, in [-2^31, 2^31) s.
inline Time TimeOf(std::int64_t ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t sec = ns / kSecond - (ns % kSecond < 0);
  return {static_cast<std::int32_t>(sec), static_cast<std::uint32_t>(ns - sec * kSecond)};
}
inline std::int64_t Nanoseconds(const Time& time) {
  return time.sec * std::int64_t{1'000'000'000} + time.nanosec;
}

struct Header {
  Time stamp;
  std::string frame_id;
};
template <class V>
void Members(V& v, Header& m) {
  v(m.stamp, m.frame_id);
}

struct Vector3 {  // and Point
  double x = 0, y = 0, z = 0;
};
template <class V>
void Members(V& v, Vector3& m) {
  v(m.x, m.y, m.z);
}

struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
template <class V>
void Members(V& v, Quaternion& m) {
  v(m.x, m.y, m.z, m.w);
}

struct Transform {  // and Pose, whose members are called position and orientation
  Vector3 translation;
  Quaternion rotation;
};
template <class V>
void Members(V& v, Transform& m) {
  v(m.translation, m.rotation);
}

struct Twist {
  Vector3 linear, angular;
};
template <class V>
void Members(V& v, Twist& m) {
  v(m.linear, m.angular);
}

struct PoseStamped {
  static constexpr const char* kType = "geometry_msgs/msg/PoseStamped";
  Header header;
  Transform pose;
};
template <class V>
void Members(V& v, PoseStamped& m) {
  v(m.header, m.pose);
}

struct TwistStamped {
  static constexpr const char* kType = "geometry_msgs/msg/TwistStamped";
  Header header;
  Twist twist;
};
template <class V>
void Members(V& v, TwistStamped& m) {
  v(m.header, m.twist);
}

struct Vector3Stamped {
  static constexpr const char* kType = "geometry_msgs/msg/Vector3Stamped";
  Header header;
  Vector3 vector;
};
template <class V>
void Members(V& v, Vector3Stamped& m) {
  v(m.header, m.vector);
}

struct Odometry {
  static constexpr const char* kType = "nav_msgs/msg/Odometry";
  Header header;
  std::string child_frame_id;
  Transform pose;                             // of the child's frame in the header's
  std::array<double, 36> pose_covariance{};   // rows; all 0: not known
  Twist twist;                                // in the child's frame
  std::array<double, 36> twist_covariance{};  // the same
};
template <class V>
void Members(V& v, Odometry& m) {
  v(m.header, m.child_frame_id, m.pose, m.pose_covariance, m.twist, m.twist_covariance);
}

struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;
};
template <class V>
void Members(V& v, TransformStamped& m) {
  v(m.header, m.child_frame_id, m.transform);
}

struct TfMessage {
  static constexpr const char* kType = "tf2_msgs/msg/TFMessage";
  std::vector<TransformStamped> transforms;
};
template <class V>
void Members(V& v, TfMessage& m) {
  v(m.transforms);
}

// What mavros takes from a controller.
struct AttitudeTarget {
  static constexpr const char* kType = "mavros_msgs/msg/AttitudeTarget";
  static constexpr std::uint8_t kIgnoreRollRate = 1, kIgnorePitchRate = 2, kIgnoreYawRate = 4,
                                kIgnoreAttitude = 128;
  Header header;
  std::uint8_t type_mask = 0;
  Quaternion orientation;
  Vector3 body_rate;
  float thrust = 0;  // 0 to 1
};
template <class V>
void Members(V& v, AttitudeTarget& m) {
  v(m.header, m.type_mask, m.orientation, m.body_rate, m.thrust);
}

struct Log {
  static constexpr const char* kType = "rcl_interfaces/msg/Log";
  static constexpr std::uint8_t kInfo = 20, kWarn = 30, kError = 40;
  Time stamp;
  std::uint8_t level = kInfo;
  std::string name, msg, file, function;
  std::uint32_t line = 0;
};
template <class V>
void Members(V& v, Log& m) {
  v(m.stamp, m.level, m.name, m.msg, m.file, m.function, m.line);
}

}  // namespace kestrel::ros
