// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/wire/afcs.h"

// What both ends of an AFCS's wire must agree on beside the layout, and nobody has published: what the
// numbers mean. All of it is assumed, and to be calibrated with the aircraft at hand.
namespace kestrel::control::wire {

// An axis of the teleoperation. The aircraft's velocity is that of the command less the offset, less the dead
// zone: zero within it, and beyond it what is in excess of it. So a command that is smaller than the offset
// makes it move backwards, as the thesis has it of very small ones.
struct AfcsAxis {
  double offset = 0;
  double dead_zone = 0;
};

struct AfcsTeleopAxes {
  AfcsAxis fore, side, alt;  // m/s
  AfcsAxis hdg;              // rad/s, clockwise: taken for the rate of the heading, as the others are rates
  bool alt_up = true;
};

struct AfcsSettings {
  std::string profile = "thesis";  // of an AfcsProfile
  AfcsTeleopAxes teleop;
  int fly_to_position = 0, fly_to_heading = 0;
  int platform_relative = 0, platform_absolute = 1, platform_point = 2;
  double stopped_rpm = 100;  // AfcsState::rpm0
};

inline void Fields(FieldVisitor& v, AfcsAxis& a) {
  v({"offset", "command at which the aircraft stands still, in m/s, of hdg in rad/s"}, a.offset, -2.0, 2.0);
  v({"dead_zone", "command to either side of the offset that has no effect, in m/s, of hdg in rad/s"},
    a.dead_zone, 0.0, 2.0);
}
inline void Fields(FieldVisitor& v, AfcsTeleopAxes& t) {
  v({"fore", "offset and dead zone of the velocity forward"}, t.fore);
  v({"side", "offset and dead zone of the velocity to the right"}, t.side);
  v({"alt", "offset and dead zone of the vertical velocity"}, t.alt);
  v({"hdg", "offset and dead zone of the yaw rate, clockwise positive"}, t.hdg);
  v({"alt_up", "a positive vertical command climbs; false: it descends"}, t.alt_up);
}
inline void Fields(FieldVisitor& v, AfcsSettings& s) {
  v({"profile", "layout of the messages: thesis, or a YAML file"}, s.profile);
  v({"teleop", "calibration of the velocity commands (TELEOP)"}, s.teleop);
  v({"fly_to_position", "value of pos_mode in FLY_TO for a position north-east-down"}, s.fly_to_position,
    -32768, 32767);
  v({"fly_to_heading", "value of hdg_mode in FLY_TO for a heading clockwise from north"}, s.fly_to_heading,
    -32768, 32767);
  v({"platform_relative", "value of mode in PLATFORM for angles relative to the aircraft"},
    s.platform_relative, -32768, 32767);
  v({"platform_absolute", "value of mode in PLATFORM for angles relative to north and the vertical"},
    s.platform_absolute, -32768, 32767);
  v({"platform_point", "value of mode in PLATFORM for a point to look at, north-east-down"}, s.platform_point,
    -32768, 32767);
  v({"stopped_rpm",
     "speed of the main rotor below which the aircraft has landed; 0: landing is not detected"},
    s.stopped_rpm, 0.0, 65535.0);
}

// The one that is named. Throws InputError with all that is wrong with a file.
AfcsProfile ProfileOf(const AfcsSettings& settings);

// The command for a velocity, and the velocity that comes of a command: each undoes the other.
AfcsTeleop TeleopFor(const VelocitySetpoint& wanted, const AfcsTeleopAxes& axes);
VelocitySetpoint VelocityOf(const AfcsTeleop& teleop, const AfcsTeleopAxes& axes);

}  // namespace kestrel::control::wire
