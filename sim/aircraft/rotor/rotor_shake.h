// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/fields.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// What a rotor shakes of an inertial unit on its mount: amplitudes at the governed rotor speed, once a turn
// (an unbalanced disc: a force that turns in its plane, and the tilting that goes with it) and once for every
// blade that passes (up and down, and nodding). They go with the square of the rotor speed.
struct RotorShake {
  double turn_m_s2 = 1.0, blade_m_s2 = 2.0;
  double turn_rad_s = 0.02, blade_rad_s = 0.02;
};

inline void Fields(FieldVisitor& v, RotorShake& s) {
  v({"turn_m_s2", "amplitude of acceleration once a turn, at the governed speed, by an unbalanced disc"},
    s.turn_m_s2, 0.0, 50.0);
  v({"blade_m_s2", "amplitude of acceleration once for each blade that passes"}, s.blade_m_s2, 0.0, 50.0);
  v({"turn_rad_s", "amplitude of the angular rate once a turn"}, s.turn_rad_s, 0.0, 5.0);
  v({"blade_rad_s", "amplitude of the angular rate once for each blade that passes"}, s.blade_rad_s, 0.0,
    5.0);
}

// Added to the true rates and specific force. azimuth: rad, of a blade, clockwise from ahead as seen from
// above; share: of the governed rotor speed.
ImuSample ShakeAt(const RotorShake& s, double azimuth, int blades, double share);

}  // namespace kestrel::sim
