// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace kestrel::sim {
namespace {

using control::wire::mavlink::Dialect;
using control::wire::mavlink::kArduPilot;
using control::wire::mavlink::kPx4;

// MAV_MODE_FLAG
constexpr std::uint8_t kAuto = 4, kGuided = 8, kStabilize = 16, kManualInput = 64;
// PX4's modes by themselves have all three; ground stations name a mode by them.
constexpr std::uint8_t kPx4Own = kAuto | kGuided | kStabilize, kPx4Sticks = kManualInput | kStabilize;
constexpr std::uint8_t kArduPilotAny = kGuided | kStabilize | kManualInput;

constexpr std::uint32_t Px4Mode(std::uint32_t main, std::uint32_t sub = 0) { return main << 16 | sub << 24; }

constexpr std::array kPx4Modes{
    MavlinkMode{Px4Mode(4, 3), MavlinkDoing::kHold, kPx4Own},
    MavlinkMode{Px4Mode(3), MavlinkDoing::kPilot, kPx4Sticks},
    MavlinkMode{kPx4.setpoint_mode, MavlinkDoing::kSetpoints, kPx4Own},
    MavlinkMode{Px4Mode(4, 2), MavlinkDoing::kTakeOff, kPx4Own},
    MavlinkMode{kPx4.land_mode, MavlinkDoing::kLand, kPx4Own},
    MavlinkMode{kPx4.return_mode, MavlinkDoing::kReturn, kPx4Own},
};
// LOITER is the pilot's, and what it is in by itself; BRAKE is how ground stations make it wait.
constexpr std::array kArduPilotModes{
    MavlinkMode{5, MavlinkDoing::kPilot, kArduPilotAny},
    MavlinkMode{17, MavlinkDoing::kHold, kArduPilotAny},
    MavlinkMode{kArduPilot.setpoint_mode, MavlinkDoing::kSetpoints, kArduPilotAny},
    MavlinkMode{kArduPilot.land_mode, MavlinkDoing::kLand, kArduPilotAny},
    MavlinkMode{kArduPilot.return_mode, MavlinkDoing::kReturn, kArduPilotAny},
};

struct Name {
  std::uint32_t mode;
  std::string_view name;
};
constexpr std::array kPx4Names{
    Name{Px4Mode(1), "MANUAL"},          Name{Px4Mode(2), "ALTCTL"},
    Name{Px4Mode(3), "POSCTL"},          Name{Px4Mode(5), "ACRO"},
    Name{Px4Mode(6), "OFFBOARD"},        Name{Px4Mode(7), "STABILIZED"},
    Name{Px4Mode(4, 2), "AUTO.TAKEOFF"}, Name{Px4Mode(4, 3), "AUTO.LOITER"},
    Name{Px4Mode(4, 4), "AUTO.MISSION"}, Name{Px4Mode(4, 5), "AUTO.RTL"},
    Name{Px4Mode(4, 6), "AUTO.LAND"},
};
constexpr std::array kArduPilotNames{
    Name{0, "STABILIZE"}, Name{1, "ACRO"},     Name{2, "ALT_HOLD"}, Name{3, "AUTO"},
    Name{4, "GUIDED"},    Name{5, "LOITER"},   Name{6, "RTL"},      Name{7, "CIRCLE"},
    Name{9, "LAND"},      Name{16, "POSHOLD"}, Name{17, "BRAKE"},   Name{21, "SMART_RTL"},
};

}  // namespace

std::span<const MavlinkMode> ModesOf(const Dialect& dialect) {
  if (&dialect == &kPx4) return kPx4Modes;
  return kArduPilotModes;
}

const MavlinkMode* FindMode(const Dialect& dialect, std::uint32_t custom_mode) {
  const auto modes = ModesOf(dialect);
  const auto found = std::ranges::find(modes, custom_mode, &MavlinkMode::custom_mode);
  return found == modes.end() ? nullptr : &*found;
}

const MavlinkMode* FindMode(const Dialect& dialect, MavlinkDoing doing) {
  const auto modes = ModesOf(dialect);
  const auto found = std::ranges::find(modes, doing, &MavlinkMode::doing);
  return found == modes.end() ? nullptr : &*found;
}

std::string NameOfMode(const Dialect& dialect, std::uint32_t custom_mode) {
  const auto names =
      &dialect == &kPx4 ? std::span<const Name>(kPx4Names) : std::span<const Name>(kArduPilotNames);
  const auto found = std::ranges::find(names, custom_mode, &Name::mode);
  return found == names.end() ? fmt::format("mode {}", custom_mode) : std::string(found->name);
}

}  // namespace kestrel::sim
