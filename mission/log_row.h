// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "geometry/truth.h"
#include "mission/decision.h"

namespace kestrel::mission {

// One frame of a flight: a line of telemetry.csv. Of a real aircraft no truth is known: exposure and now hold
// their times alone.
struct LogRow {
  std::int64_t sequence = 0;
  Truth exposure;                  // when the frame was exposed: what the fix is judged by
  Truth now;                       // when the decision was made
  control::VehicleState estimate;  // when the decision was made
  Decision decision;               // its texts are string literals of the mission
  // Of a real aircraft:
  bool heard = true;  // otherwise its autopilot never was: nothing of the estimate is known
  std::optional<control::Setpoint> sent =
      {};  // after the safety layer, or would be in a dry run; none: nothing
  std::string_view hazard = {}, reaction = {};  // of the safety layer, string literals
};

}  // namespace kestrel::mission
