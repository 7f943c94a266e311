// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// Which of the two flies: in every start line, log and overlay.
inline constexpr const char* kSimulatorMode = "SIMULATOR";
inline constexpr const char* kRealMode = "REAL AIRCRAFT";
inline constexpr const char* kDryRunMode = "REAL AIRCRAFT, DRY RUN: no setpoint is sent";

}  // namespace kestrel
