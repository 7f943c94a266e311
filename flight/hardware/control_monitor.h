// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "control/autopilot.h"
#include "control/link/safe_autopilot.h"

namespace kestrel::flight {

// Who had a real aircraft: told of the safety layer and the state as a flight goes on, it says how the flight
// ended. A flight passes only if its mission did what it is for under its own control.
class ControlMonitor {
 public:
  // After its touch-down an aircraft is landed once the autopilot's logic says so, at most this much later.
  static constexpr double kTouchDown_s = 2;

  // In the order of time. safety: what is in force; state: as it is known, in the air while nothing was
  // heard.
  void Note(double t_s, const control::SafetyChange& safety, const control::VehicleState& state);

  struct Verdict {
    std::string outcome;
    bool accomplished = false;
  };
  // outcome: the mission's; empty: it had none when the flight ended, and why tells what ended it.
  // accomplished: the mission has done what it is for.
  Verdict Judge(const std::string& outcome, const std::string& why, bool accomplished) const;

  static constexpr const char* kTimeIsUp = "time is up";  // the one end from outside that is a good one

 private:
  bool flew_ = false;      // the mission's setpoints were sent
  bool airborne_ = false;  // at some time
  std::optional<control::SafetyChange> last_, landing_;
  std::optional<control::SafetyChange> silent_;  // the first time that nothing was sent, once it had flown
  std::optional<control::SafetyChange> sunk_;    // at its t_s at the latest
};

}  // namespace kestrel::flight
