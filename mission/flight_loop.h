// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "control/autopilot.h"
#include "mission/mission.h"
#include "vision/camera.h"

namespace kestrel::mission {

// A number in a measurement, a setpoint or the autopilot's state is not one: names which, and when.
struct NotANumber : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws NotANumber if one is in these. In the simulator that is a mistake of the program and ends the run;
// on a real aircraft the safety layer reacts instead (control/safety/safety.h).
void RequireNumbers(const vision::Frame& frame, const control::VehicleState& state, const Decision& decision);

// The flight loop, the same for the simulator and for a real aircraft: until the camera's stream or the
// mission ends. record is called once for each frame and returns whether to go on. Returns the mission's
// outcome; empty: the stream ended first, or record said so.
std::string Fly(
    vision::Camera& camera, control::Autopilot& autopilot, Mission& mission,
    const std::function<bool(const vision::Frame&, const control::VehicleState&, const Decision&)>& record);

}  // namespace kestrel::mission
