// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/pose.h"

// What instruments give. t_ns: the instant that a reading is of, by the instrument's own clock.
namespace kestrel::sim {

// In I, the axes of the IMU (ImuParameters): those of B where its mount says nothing.
struct ImuReading {
  std::int64_t t_ns = 0;
  Eigen::Vector3d w_I = Eigen::Vector3d::Zero();               // rad/s
  Eigen::Vector3d specific_force_I = Eigen::Vector3d::Zero();  // m/s^2; at rest, level: (0, 0, -g)
};

struct GpsReading {
  std::int64_t t_ns = 0;
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero(), v_N = Eigen::Vector3d::Zero();  // of the antenna; m, m/s
};

struct BarometerReading {
  std::int64_t t_ns = 0;
  double height_m = 0;     // above the origin of N
  double pressure_pa = 0;  // of that height in the International Standard Atmosphere, its sea level there
};

struct MagnetometerReading {
  std::int64_t t_ns = 0;
  Eigen::Vector3d field_B = Eigen::Vector3d::Zero();  // T
};

// Infinite: nothing within the longest range; minus infinite: nearer than the shortest (REP 117).
struct RangeReading {
  std::int64_t t_ns = 0;
  double range_m = 0;  // along the beam
};

// The truth at the instant of an IMU reading, by the flight's clock; and what the IMU's biases then are.
struct TruthSample {
  std::int64_t t_ns = 0;
  Pose X_NB;
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d gyroscope_bias_I = Eigen::Vector3d::Zero(), accelerometer_bias_I = Eigen::Vector3d::Zero();
};

// Each in the order of time.
struct Readings {
  std::vector<ImuReading> imu;
  std::vector<TruthSample> truth;  // truth[i]: of imu[i]
  std::vector<GpsReading> gps;
  std::vector<BarometerReading> barometer;
  std::vector<MagnetometerReading> magnetometer;
  std::vector<RangeReading> rangefinder;
};

// Adds later readings.
inline void Append(Readings& all, const Readings& later) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(all.imu, later.imu);
  append(all.truth, later.truth);
  append(all.gps, later.gps);
  append(all.barometer, later.barometer);
  append(all.magnetometer, later.magnetometer);
  append(all.rangefinder, later.rangefinder);
}

}  // namespace kestrel::sim
