// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Which way the AscTec processor's angles and sticks count, which no public document says. In the one place
// where it is decided: each is +1 or -1, and the value of the conventions here (roll right wing down, pitch
// nose up, yaw clockwise) is the sign times the wire's. Unverified on the aircraft: before a flight, lean and
// turn it by hand and see that the angles follow, and let the pilot hold it while a small angle is asked for.
namespace kestrel::control::wire {

struct AscTecSigns {
  int angle_roll = 1, angle_nick = -1, angle_yaw = 1;   // of IMU_CALCDATA, angles and rates
  int stick_roll = 1, stick_pitch = -1, stick_yaw = 1;  // of CTRL_INPUT
};

// "asctec": the angles count as a pilot's sticks do, forward, right and clockwise positive; the sticks as in
// the firmware of asctec_mav_framework. "ros": as the driver asctec_proc of asctec_drivers reads and sends
// them, which takes a positive angle_roll for the left wing down, yet a positive roll stick for the right,
// and a positive yaw stick for counterclockwise.
inline constexpr AscTecSigns SignsOf(std::string_view profile) {
  if (profile == "ros") return {.angle_roll = -1, .stick_yaw = -1};
  return {};
}

}  // namespace kestrel::control::wire
