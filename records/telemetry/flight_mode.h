// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel::records {

// What flies, as far as it is known: in every start line, log and overlay.
inline constexpr const char* kSimulatorMode = "SIMULATOR";
inline constexpr const char* kRecordingMode = "RECORDING";  // nothing flies: it is seen again

// Of an autopilot at the far end of a wire. Whether there is an aircraft behind it the wire does not tell,
// unless it says that there is none: simulated.
inline std::string LiveMode(bool simulated, bool dry_run) {
  return std::string("LIVE") + (simulated ? ", SIMULATED AIRCRAFT" : "") +
         (dry_run ? ", DRY RUN: no setpoint is sent" : "");
}

}  // namespace kestrel::records
