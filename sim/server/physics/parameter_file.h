// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/aircraft/multirotor.h"

namespace kestrel::sim {

// The file of parameters by which an autopilot of software in the loop flies a simulated aircraft, each with its reason.
// What is not in it stays as the autopilot comes.
//
//   ardupilot  ardupilot.parm: NAME VALUE, as --defaults of ArduPilot's own program and MAVProxy's `param load` read it
//   px4        px4.params: vehicle, component, NAME, VALUE and type between tabs, as QGroundControl reads it
//
// Both take a line that begins with # as a comment. ArduPilot reads lines of up to 98 characters.

// In the folder of the vehicle, a name in models/vehicles or a file: ardupilot.parm; beside a file that is not alone in
// a folder of its name, NAME.ardupilot.parm, as others may be there.
std::string ParameterFileName(const std::string& autopilot, const std::string& vehicle);

// vehicle: as the command that writes the file was given it, of which the last part is told. Throws
// std::runtime_error: ArduPilot has no layout with these rotors (sim/server/physics/motor_layout.h).
std::string ParameterText(const std::string& autopilot, const std::string& vehicle,
                          const MultirotorParameters& aircraft);

}  // namespace kestrel::sim
