// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "control/safety/safety.h"

// How an aircraft in flight is let go. The last velocity stays in force at the far end of a silent wire until
// its own time-out, of an ArduPilot for three seconds; so first it is told to stand still, and silence comes
// when it does.
namespace kestrel::control {

enum class Release {
  kHolding,    // velocity zero is being sent
  kHeld,       // it was obeyed
  kNotObeyed,  // it was not, in max_s
  kStateLost,  // the same, and nobody can say whether it was
  kOwnHold,    // the autopilot holds the place by itself: nothing is followed that we send
  kLanded,     // nothing to be held
  kPilot,      // his switch is off, or unknown: the aircraft is his
};

struct ReleaseLimits {
  double speed_m_s = 0.25, yaw_rate_deg_s = 10;  // slower than both is standing still
  double still_s = 1;                            // for so long without a break
  double max_s = 5;
};

struct ReleaseState {
  double since_s = 0;                   // of velocity zero
  std::optional<double> still_since_s;  // none: it moves
};

// One step, at now.t_s; of a Situation it looks at the pilot, the state and its age. Velocity zero is to be
// sent while it returns kHolding; anything else is the end, and silence from then on.
Release LetGo(const Situation& now, ReleaseState& state, const SafetyLimits& limits,
              const ReleaseLimits& release = {});

std::string TextOf(Release release, double after_s);  // of an end, for the log

}  // namespace kestrel::control
