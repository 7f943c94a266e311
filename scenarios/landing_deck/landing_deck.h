// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/touch_down/go_around.h"
#include "scenarios/landing_deck/deck_pilot.h"

namespace kestrel::scenarios {

// A landing on a deck that drives, or heaves, rolls and pitches. It waits until it sees the pad, comes up with it,
// follows, and descends in the deck's moving frame. It goes below the decision height when the deck as predicted for
// the moment of touch-down is within the limits, and goes around when it no longer is, or is out of sight too high.
struct LandingDeckFlight {
  double yaw_deg = 0;
  double follow_m = 3;
  double centred_m = 0.2, matched_m_s = 0.6;
  double descent_m_s = 0.9, commit_sink_m_s = 0.4;
  double last_look_m = 0.7, blind_m = 0.45, coast_s = 0.6;
  double stands_m = 0.16;
  double press_m_s = 1.2;
  double rest_s = 2;
  double drag_per_s = 0.18;
  DeckPilotParameters pilot;
  mission::TouchDownLimits limits{.tilt_deg = 20, .sink_m_s = 1, .speed_m_s = 0.8, .wind_m_s = 16};
  mission::GoAroundParameters go_around{
      .decision_m = 1.2, .share = 0.75, .wait_first = true, .wait_s = 20, .attempts = 5, .climb_m_s = 1};
};

inline void Fields(FieldVisitor& v, LandingDeckFlight& p) {
  v({"yaw_deg", "heading to land with, clockwise from the top of the pad's picture"}, p.yaw_deg, -180.0,
    180.0);
  v({"follow_m", "height above the pad at which the deck is come up with and followed"}, p.follow_m, 0.5,
    20.0);
  v({"centred_m", "horizontal error, plus a tenth of the height, up to which the aircraft descends"},
    p.centred_m, 0.01, 2.0);
  v({"matched_m_s", "speed by the deck's up to which the aircraft descends"}, p.matched_m_s, 0.05, 5.0);
  v({"descent_m_s", "maximum speed of the descent, by the deck's"}, p.descent_m_s, 0.1, 3.0);
  v({"commit_sink_m_s", "speed, by the deck's, with which the aircraft sinks below the decision height"},
    p.commit_sink_m_s, 0.15, 2.0);
  v({"last_look_m", "height above the pad below which an approach is broken off for what is expected"},
    p.last_look_m, 0.1, 5.0);
  v({"blind_m", "height above the pad below which the aircraft goes on without seeing it"}, p.blind_m, 0.0,
    2.0);
  v({"coast_s", "time out of sight above that height after which the approach is broken off"}, p.coast_s, 0.0,
    10.0);
  v({"stands_m", "height above the pad of an aircraft that stands on it"}, p.stands_m, 0.0, 3.0);
  v({"press_m_s", "speed, by the deck's, that is asked for once it stands, so that its autopilot notices"},
    p.press_m_s, 0.2, 3.0);
  v({"rest_s", "time after the motors have stopped for which it is watched where it stays"}, p.rest_s, 0.0,
    60.0);
  v({"drag_per_s", "deceleration by each m/s of air, by which the wind over deck is told from the lean"},
    p.drag_per_s, 0.01, 5.0);
  v({"pilot", "what is made of the deck's motion"}, p.pilot);
  v({"limits", "limits of the touch-down, against the deck"}, p.limits);
  v({"go_around", "when an approach waits or is broken off, and how often it is tried again"}, p.go_around);
}

void CheckFlight(const LandingDeckFlight& flight, const Place& where, Mistakes& mistakes);
// A pad that is lost above the height at which it need no longer be seen.
void CheckFlightPad(const LandingDeckFlight& flight, double seen_from_m, const Place& where,
                    Mistakes& mistakes);
mission::MissionType TypeOf(const LandingDeckFlight& flight);
std::unique_ptr<mission::Mission> MakeMission(const LandingDeckFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
