// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// How an autopilot finds one of its sensors.
enum class SensorHealth {
  kOk,
  kSilent,   // has measured nothing for five of its periods, an inertial one for 0.1 s
  kStuck,    // says the same to the last bit again and again: 10 readings, an inertial one for 0.1 s
  kRefused,  // what it says has been too far for a second from what the navigation expects
};

struct NavigationHealth {
  SensorHealth gyro = SensorHealth::kOk, accelerometer = SensorHealth::kOk, compass = SensorHealth::kOk,
               barometer = SensorHealth::kOk, gps = SensorHealth::kOk;
  bool operator==(const NavigationHealth&) const = default;
};

// In words, with what the navigation does without: "ok", "gps silent: dead reckoning".
std::string NameOf(const NavigationHealth& health);

// Watches what the sensors say, for sensors that are silent or stuck. It knows nothing of the faults but by
// what they do to the readings.
class SensorMonitor {
 public:
  explicit SensorMonitor(const SensorParameters& sensors);

  void Step(double dt_s, const SensorReadings& readings);
  const NavigationHealth& health() const { return health_; }  // none refused

 private:
  template <int size>
  struct Record {
    Eigen::Matrix<double, size, 1> last = Eigen::Matrix<double, size, 1>::Constant(1e300);
    double silent_s = 0, same_s = 0;
    int same = 0;

    SensorHealth Step(double dt_s, bool spoke, const Eigen::Matrix<double, size, 1>& measured,
                      double patience_s, bool inertial);
  };

  double gps_period_s_, barometer_period_s_, magnetometer_period_s_;
  Record<3> gyro_, accelerometer_, compass_;
  Record<1> barometer_;
  Record<6> gps_;
  NavigationHealth health_;
};

}  // namespace kestrel::sim
