// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "control/wire/mavlink_messages.h"
#include "geometry/truth.h"
#include "sim/server/geodetic_origin.h"
#include "sim/server/physics/gathered_readings.h"

// Sensors and truth as the messages that PX4 takes from a simulator, in their units. PX4's body
// frame is B.
namespace kestrel::sim {

// The international standard atmosphere (ISO 2533) up to 11 km.
double StandardPressure_hpa(double altitude_m);
double StandardTemperature_c(double altitude_m);

// What HIL_SENSOR holds of magnetometer and barometer while they are silent.
struct SlowSensors {
  Eigen::Vector3d field_B = EarthField_N();  // T
  double height_m = 0;                       // above the origin
};

// readings: of one step at least. slow is brought up to date with them. The temperature is the standard
// atmosphere's, there is no air speed.
control::wire::mavlink::HilSensor ToHilSensor(std::uint64_t time_usec, const GatheredReadings& readings,
                                              SlowSensors& slow, const GeodeticOrigin& origin);

// eph and epv are 100: a dilution of 1 as MAVLink has it, 1 m as PX4 reads it. Ten satellites.
control::wire::mavlink::HilGps ToHilGps(std::uint64_t time_usec, const GpsSample& gps,
                                        const GeodeticOrigin& origin);

// specific_force_B in m/s^2.
control::wire::mavlink::HilStateQuaternion ToHilState(std::uint64_t time_usec, const Truth& truth,
                                                      const Eigen::Vector3d& specific_force_B,
                                                      const GeodeticOrigin& origin);

}  // namespace kestrel::sim
