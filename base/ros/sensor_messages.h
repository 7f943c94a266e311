// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/ros/messages.h"

// sensor_msgs of ROS 2, as messages.h.
namespace kestrel::ros {

struct Image {
  static constexpr const char* kType = "sensor_msgs/msg/Image";
  Header header;  // stamp of the exposure; frame_id of the camera: x right, y down, z forward
  std::uint32_t height = 0, width = 0;
  std::string encoding;  // "mono8", "bgr8", ...
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;  // bytes of a row
  std::vector<std::uint8_t> data;
};
template <class V>
void Members(V& v, Image& m) {
  v(m.header, m.height, m.width, m.encoding, m.is_bigendian, m.step, m.data);
}

struct CompressedImage {
  static constexpr const char* kType = "sensor_msgs/msg/CompressedImage";
  Header header;
  std::string format;  // "jpeg", "png"; of image_transport with more before it: "mono8; jpeg compressed"
  std::vector<std::uint8_t> data;
};
template <class V>
void Members(V& v, CompressedImage& m) {
  v(m.header, m.format, m.data);
}

struct RegionOfInterest {
  std::uint32_t x_offset = 0, y_offset = 0, height = 0, width = 0;
  bool do_rectify = false;
};
template <class V>
void Members(V& v, RegionOfInterest& m) {
  v(m.x_offset, m.y_offset, m.height, m.width, m.do_rectify);
}

struct CameraInfo {
  static constexpr const char* kType = "sensor_msgs/msg/CameraInfo";
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{}, r{};  // rows
  std::array<double, 12> p{};      // rows
  std::uint32_t binning_x = 0, binning_y = 0;
  RegionOfInterest roi;
};
template <class V>
void Members(V& v, CameraInfo& m) {
  v(m.header, m.height, m.width, m.distortion_model, m.d, m.k, m.r, m.p, m.binning_x, m.binning_y, m.roi);
}

// Covariances by rows; all 0: not known; the first -1: the quantity is not measured.
struct Imu {
  static constexpr const char* kType = "sensor_msgs/msg/Imu";
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity;  // rad/s
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;  // m/s^2, specific force: at rest, up is +9.81
  std::array<double, 9> linear_acceleration_covariance{};
};
template <class V>
void Members(V& v, Imu& m) {
  v(m.header, m.orientation, m.orientation_covariance, m.angular_velocity, m.angular_velocity_covariance,
    m.linear_acceleration, m.linear_acceleration_covariance);
}

struct NavSatFix {
  static constexpr const char* kType = "sensor_msgs/msg/NavSatFix";
  Header header;
  std::int8_t status = 0;                       // of the fix: -1 none, 0 by itself
  std::uint16_t service = 1;                    // GPS
  double latitude = 0, longitude = 0;           // deg
  double altitude = 0;                          // m above the ellipsoid
  std::array<double, 9> position_covariance{};  // m^2, of east, north, up
  std::uint8_t position_covariance_type = 0;    // 0: not known, 2: its diagonal is
};
template <class V>
void Members(V& v, NavSatFix& m) {
  v(m.header, m.status, m.service, m.latitude, m.longitude, m.altitude, m.position_covariance,
    m.position_covariance_type);
}

struct FluidPressure {
  static constexpr const char* kType = "sensor_msgs/msg/FluidPressure";
  Header header;
  double fluid_pressure = 0;  // Pa
  double variance = 0;        // Pa^2; 0: not known
};
template <class V>
void Members(V& v, FluidPressure& m) {
  v(m.header, m.fluid_pressure, m.variance);
}

struct MagneticField {
  static constexpr const char* kType = "sensor_msgs/msg/MagneticField";
  Header header;
  Vector3 magnetic_field;  // T
  std::array<double, 9> magnetic_field_covariance{};
};
template <class V>
void Members(V& v, MagneticField& m) {
  v(m.header, m.magnetic_field, m.magnetic_field_covariance);
}

struct Range {
  static constexpr const char* kType = "sensor_msgs/msg/Range";
  Header header;
  std::uint8_t radiation_type = 1;                // 0: ultrasound, 1: infrared
  float field_of_view = 0;                        // rad
  float min_range = 0, max_range = 0, range = 0;  // m; -inf, inf: nearer, farther
  float variance = 0;
};
template <class V>
void Members(V& v, Range& m) {
  v(m.header, m.radiation_type, m.field_of_view, m.min_range, m.max_range, m.range, m.variance);
}

}  // namespace kestrel::ros
