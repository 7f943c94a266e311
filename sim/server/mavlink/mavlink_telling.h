// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "control/autopilot.h"
#include "control/wire/mavlink_dialects.h"
#include "sim/server/geodetic_origin.h"
#include "sim/server/mavlink/mavlink_modes.h"

namespace kestrel::sim {

// What an emulated autopilot tells of itself, as messages.
struct MavlinkTold {
  const control::VehicleState& state;  // its own estimate
  const control::wire::mavlink::Dialect& dialect;
  const GeodeticOrigin& origin;
  Eigen::Vector3d home_N;
  MavlinkDoing doing;
  bool armed, pilot_allows;
  int system;          // MAVLink system ID
  int switch_channel;  // of RC_CHANNELS
  double unix_s;       // the time of day
};

struct MavlinkOffer {
  std::uint32_t id = 0;
  double px4_hz = 0;        // unasked, as PX4 does; 0: only when asked
  std::uint8_t stream = 0;  // MAV_DATA_STREAM by which ArduPilot is asked for it; 0: by none
};

std::span<const MavlinkOffer> MavlinkOffers();

// None: of no such message. What it does not measure is told as unknown: it has no battery, and of its satellites only
// that they suffice.
std::optional<control::wire::mavlink::Message> Tell(std::uint32_t id, const MavlinkTold& told);

}  // namespace kestrel::sim
