// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// Sensors that say the truth, at their usual rates.
inline SensorParameters PerfectSensors() {
  SensorParameters p;
  p.gyro_noise_rad_s_rthz = p.gyro_walk_rad_s2_rthz = p.gyro_turn_on_rad_s = 0;
  p.accelerometer_noise_m_s2_rthz = p.accelerometer_walk_m_s3_rthz = p.accelerometer_turn_on_m_s2 = 0;
  p.magnetometer_white_t = p.magnetometer_turn_on_t = 0;
  for (SensorError* e : {&p.gps_horizontal_m, &p.gps_vertical_m, &p.gps_velocity_m_s, &p.barometer_m}) {
    e->white = e->wander = 0;
  }
  return p;
}

}  // namespace kestrel::sim
