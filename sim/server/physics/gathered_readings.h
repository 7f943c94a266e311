// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// What the sensors said over some steps, for a message that is sent less often than the physics are stepped.
// The mean of the inertial samples keeps what an autopilot makes of them, their integrals.
class GatheredReadings {
 public:
  void Add(const SensorReadings& readings) {
    sum_.w_B += readings.imu.w_B;
    sum_.specific_force_B += readings.imu.specific_force_B;
    ++steps_;
    if (readings.gps) gps = readings.gps;
    if (readings.height_m) height_m = readings.height_m;
    if (readings.field_B) field_B = readings.field_B;
  }
  int steps() const { return steps_; }
  ImuSample MeanImu() const { return {sum_.w_B / steps_, sum_.specific_force_B / steps_}; }

  // The newest; none: not in these steps.
  std::optional<GpsSample> gps;
  std::optional<double> height_m;
  std::optional<Eigen::Vector3d> field_B;

 private:
  ImuSample sum_{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  int steps_ = 0;
};

}  // namespace kestrel::sim
