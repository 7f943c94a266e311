// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/gravity.h"
#include "base/random.h"
#include "sim/sensor/sensor_fault.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// The ranges of garbage. Gyroscopes, accelerometers and magnetometer: of the ADIS16448. Barometer: the
// heights of pressures of 1100 to 300 hPa. GPS: the speeds of a u-blox 6; positions assumed.
struct SensorRanges {
  double gyro_deg_s = 1000;
  double accelerometer_m_s2 = 18 * kGravity_m_s2;
  double magnetometer_t = 190e-6;
  double height_low_m = -700, height_high_m = 9200;
  double gps_m = 1e4, gps_m_s = 500;
};

// What lies between the sensors and the autopilot: takes what the sensors said in a step and leaves what the
// autopilot hears. Without a fault the readings go through untouched.
class SensorFaults {
 public:
  SensorFaults(std::vector<SensorFault> faults, std::uint64_t seed);
  SensorFaults(const SensorFaults&) = delete;
  SensorFaults& operator=(const SensorFaults&) = delete;

  // From the next step on there are these. A fault that goes on goes on as it was.
  void Change(std::vector<SensorFault> faults);

  // To be called for every step, in the order of time; t_s: at its end.
  void Apply(double t_s, SensorReadings& readings);

 private:
  template <class T>
  struct Channel {
    Channel(const char* of, std::uint64_t seed);
    // Of what the sensor said, what is heard.
    std::optional<T> Pass(const std::vector<SensorFault>& faults, double t_s,
                          const std::optional<T>& measured);

    std::string component;
    RandomStream random;
    const SensorFault* fault = nullptr;     // the one that holds
    std::optional<T> last;                  // heard
    double next_s = 0;                      // slow: when it may speak again
    std::deque<std::pair<double, T>> late;  // delayed: with the time when they are heard
  };

  std::vector<SensorFault> faults_;
  Channel<Eigen::Vector3d> gyro_, accelerometer_, magnetometer_;
  Channel<double> barometer_;
  Channel<GpsSample> gps_;
};

}  // namespace kestrel::sim
