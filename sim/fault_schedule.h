// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "sim/aircraft/actuator_faults.h"
#include "sim/aircraft/airframe.h"
#include "sim/sensor/sensor_fault.h"

namespace kestrel::sim {

// Something that changed its state, for events.log: "gps" is "off", "motor 2" is "ok".
struct StateChange {
  double t_s = 0;
  std::string what, is;
};

// Every beginning and end of a fault of sensors and of the actuators that the aircraft has, in the order of
// time.
std::vector<StateChange> ChangesOf(const std::vector<SensorFault>& sensors,
                                   const std::vector<ActuatorFault>& actuators,
                                   const AirframeParameters& aircraft);

// Faults that end before they begin, sensors that are slow and yet faster than they are, actuators that the
// aircraft has not. where: the place of the keys "sensors" and "actuators".
void CheckFaults(const SensorParameters& sensors, const ActuatorParameters& actuators,
                 const AirframeParameters& aircraft, const Place& where_sensors, const Place& where_actuators,
                 Mistakes& mistakes);

}  // namespace kestrel::sim
