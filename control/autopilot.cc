// SPDX-License-Identifier: Apache-2.0
#include "control/autopilot.h"

namespace kestrel {

const char* NameOf(FlightMode mode) {
  switch (mode) {
    case FlightMode::kStopped:
      return "stopped";
    case FlightMode::kTakeOff:
      return "take-off";
    case FlightMode::kVelocity:
      return "velocity";
    case FlightMode::kPosition:
      return "position";
    case FlightMode::kAttitude:
      return "attitude";
    case FlightMode::kHold:
      return "hold";
  }
  return "?";
}

}  // namespace kestrel
