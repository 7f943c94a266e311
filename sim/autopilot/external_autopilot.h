// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "geometry/truth.h"
#include "sim/aircraft/airframe.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// Who moves the rotors from outside, in place of the emulated autopilot: see Simulator::FlyBy.
class ExternalAutopilot {
 public:
  virtual ~ExternalAutopilot() = default;
  // After each step of the physics: what its sensors said, and the truth at its end. Returns what the rotors
  // are to do in the next one; none: the flight ends here. It may take as long as it likes: the simulated
  // time stands still meanwhile.
  virtual std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) = 0;
};

}  // namespace kestrel::sim
