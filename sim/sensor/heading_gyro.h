// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/fields.h"

namespace kestrel::sim {

// The heading-hold gyro between pedals and tail rotor, as model helicopters have: it turns the aircraft at
// the rate that the pedals ask for, and its integral holds the heading. Its own rate sensor is taken for
// perfect.
struct HeadingGyroParameters {
  double gain_s = 0.08;   // pitch of the tail rotor per rate, rad per rad/s
  double integral = 0.3;  // and per angle
};

inline void Fields(FieldVisitor& v, HeadingGyroParameters& p) {
  v({"gain_s", "pitch of the tail rotor per yaw rate error, rad per rad/s"}, p.gain_s, 0.0, 5.0);
  v({"integral", "pitch of the tail rotor per heading error, rad per rad"}, p.integral, 0.0, 20.0);
}

// The pitch asked of the tail rotor, rad, within its limits. error_rad_s: how much faster the aircraft should
// turn the way in which the tail rotor pushes. mixed: pitch that is added to the gyro's own, as mixers do
// against the main rotor's torque. integral: rad, kept by the caller; it stands still at a limit.
double HeadingGyro(const HeadingGyroParameters& p, double error_rad_s, double mixed, double low, double high,
                   double dt_s, double& integral);

}  // namespace kestrel::sim
