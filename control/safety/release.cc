// SPDX-License-Identifier: Apache-2.0
#include "control/safety/release.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {

Release LetGo(const Situation& now, ReleaseState& state, const SafetyLimits& limits,
              const ReleaseLimits& release) {
  if (!now.pilot_allows) return Release::kPilot;
  const bool over = now.t_s - state.since_s >= release.max_s;
  if (!now.state_age_s) return Release::kStateLost;  // it was never heard: there is nobody to be told
  if (!(*now.state_age_s <= limits.state_s) || !Sane(now.state)) {
    state.still_since_s.reset();
    return over ? Release::kStateLost : Release::kHolding;
  }
  if (now.state.landed) return Release::kLanded;
  if (now.state.mode == FlightMode::kHold) return Release::kOwnHold;
  const bool still = now.state.v_N.norm() < release.speed_m_s &&
                     std::abs(now.state.w_B.z()) < Radians(release.yaw_rate_deg_s);
  if (!still)
    state.still_since_s.reset();
  else if (!state.still_since_s)
    state.still_since_s = now.t_s;
  if (still && now.t_s - *state.still_since_s >= release.still_s) return Release::kHeld;
  return over ? Release::kNotObeyed : Release::kHolding;
}

std::string TextOf(Release release, double after_s) {
  switch (release) {
    case Release::kHolding:
      break;
    case Release::kHeld:
      return fmt::format("held: standing still {:.1f} s after velocity zero", after_s);
    case Release::kNotObeyed:
      return fmt::format("velocity zero not obeyed within {:.1f} s", after_s);
    case Release::kStateLost:
      return fmt::format("velocity zero for {:.1f} s; the state is lost, and whether it was obeyed not known",
                         after_s);
    case Release::kOwnHold:
      return "the autopilot holds by itself";
    case Release::kLanded:
      return "on the ground";
    case Release::kPilot:
      return "the aircraft is the pilot's";
  }
  return "velocity zero";
}

}  // namespace kestrel::control
