// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "control/wire/mavlink_dialects.h"

// The modes in which an emulated PX4 or ArduPilot can be, with what ground stations know them by. Sources:
// PX4's px4_custom_mode.h and its streams/HEARTBEAT, ArduPilot's Copter mode numbers and GCS_Copter::base_mode.
namespace kestrel::sim {

// What the vehicle does in a mode.
enum class MavlinkDoing {
  kHold,       // keeps its place, or the one that it was sent to
  kPilot,      // the pilot's own
  kSetpoints,  // follows setpoints
  kTakeOff,    // climbs, then holds
  kLand,       // sinks where it is
  kReturn,     // goes home and lands there
};

struct MavlinkMode {
  std::uint32_t custom_mode = 0;
  MavlinkDoing doing = MavlinkDoing::kHold;
  std::uint8_t base_mode = 0;  // MAV_MODE_FLAG bits that it has beside those of every mode
};

std::span<const MavlinkMode> ModesOf(const control::wire::mavlink::Dialect& dialect);
// Null: the emulation cannot be in it.
const MavlinkMode* FindMode(const control::wire::mavlink::Dialect& dialect, std::uint32_t custom_mode);
// The first mode of this kind; null: the autopilot has none.
const MavlinkMode* FindMode(const control::wire::mavlink::Dialect& dialect, MavlinkDoing doing);
// As its own documentation has it, of modes that the emulation cannot be in too: "AUTO.MISSION", "mode 77".
std::string NameOfMode(const control::wire::mavlink::Dialect& dialect, std::uint32_t custom_mode);

}  // namespace kestrel::sim
