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
  double offset = 0;     // the command at which it stands still
  double dead_zone = 0;  // on either side of that
};

struct AfcsTeleopAxes {
  AfcsAxis fore, side, alt;  // m/s
  AfcsAxis hdg;              // rad/s, clockwise: taken for the rate of the heading, as the others are rates
  bool alt_up = true;        // a positive alt climbs; otherwise it is down, as in N
};

struct AfcsSettings {
  std::string profile = "thesis";  // or a YAML file of an AfcsProfile
  AfcsTeleopAxes teleop;
  int fly_to_position = 0, fly_to_heading = 0;  // AfcsFlyTo::pos_mode and hdg_mode of a place in N
  // AfcsPlatform::mode: angles to the aircraft, angles in N, a point in N.
  int platform_relative = 0, platform_absolute = 1, platform_point = 2;
  // AfcsState::rpm0 is that of the main rotor; below this the aircraft has landed. 0: nothing tells of it.
  double stopped_rpm = 100;
};

inline void Fields(FieldVisitor& v, AfcsAxis& a) {
  v("offset", a.offset, -2.0, 2.0);
  v("dead_zone", a.dead_zone, 0.0, 2.0);
}
inline void Fields(FieldVisitor& v, AfcsTeleopAxes& t) {
  v("fore", t.fore);
  v("side", t.side);
  v("alt", t.alt);
  v("hdg", t.hdg);
  v("alt_up", t.alt_up);
}
inline void Fields(FieldVisitor& v, AfcsSettings& s) {
  v("profile", s.profile);
  v("teleop", s.teleop);
  v("fly_to_position", s.fly_to_position, -32768, 32767);
  v("fly_to_heading", s.fly_to_heading, -32768, 32767);
  v("platform_relative", s.platform_relative, -32768, 32767);
  v("platform_absolute", s.platform_absolute, -32768, 32767);
  v("platform_point", s.platform_point, -32768, 32767);
  v("stopped_rpm", s.stopped_rpm, 0.0, 65535.0);
}

// The one that is named. Throws InputError with all that is wrong with a file.
AfcsProfile ProfileOf(const AfcsSettings& settings);

// The command for a velocity, and the velocity that comes of a command: each undoes the other.
AfcsTeleop TeleopFor(const VelocitySetpoint& wanted, const AfcsTeleopAxes& axes);
VelocitySetpoint VelocityOf(const AfcsTeleop& teleop, const AfcsTeleopAxes& axes);

}  // namespace kestrel::control::wire
