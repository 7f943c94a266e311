// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/law/fuzzy/fuzzy_height.h"
#include "mission/mission_type.h"
#include "mission/pilot.h"
#include "mission/touch_down/go_around.h"

namespace kestrel::scenarios {

// Thesis 5.3.1, landing control: centre, descend over the pad, and below a height sink at a constant speed.
// It lands on a pad that it sees and on no other place: lost above blind_m, it stops, climbs and searches. It
// touches down within its limits, or goes around, and in the end aborts.
struct LandingFlight {
  double yaw_deg = 0;
  double descent_m_s = 0.7;
  double commit_m = 0.7;
  double commit_sink_m_s = 0.2;
  double blind_m = 0.35;
  double centred_m = 0.12;
  double drag_per_s = 0.18;  // of the Pelican: 0.16 at 4 m/s of air, 0.21 at 12 m/s
  mission::TouchDownLimits limits;
  mission::GoAroundParameters go_around;
  std::string height_law = "linear";  // or fuzzy, as the thesis flew it
  control::FuzzyHeight fuzzy;
};

inline void Fields(FieldVisitor& v, LandingFlight& p) {
  v({"yaw_deg", "heading to land with, clockwise from the top of the pad's picture"}, p.yaw_deg, -180.0,
    180.0);
  v({"descent_m_s", "maximum speed of the descent"}, p.descent_m_s, 0.1, 3.0);
  v({"commit_m", "height above the pad below which the aircraft sinks at a constant speed"}, p.commit_m, 0.1,
    5.0);
  v({"commit_sink_m_s",
     "speed with which the aircraft sinks below commit_m; also the minimum speed of the descent above"},
    p.commit_sink_m_s, 0.15, 1.0);
  v({"blind_m", "height above the pad below which the aircraft goes on without seeing it"}, p.blind_m, 0.0,
    2.0);
  v({"centred_m", "horizontal error, plus a tenth of the height, up to which the aircraft descends"},
    p.centred_m, 0.01, 2.0);
  v({"drag_per_s", "deceleration by each m/s of air, by which the wind is told from the aircraft's lean"},
    p.drag_per_s, 0.01, 5.0);
  v({"limits", "limits of the touch-down"}, p.limits);
  v({"go_around", "when an approach waits or is broken off, and how often it is tried again"}, p.go_around);
  v({"height_law",
     "what says how fast the aircraft descends above commit_m: in proportion to the height, or fuzzy rules"},
    p.height_law, {"linear", "fuzzy"});
  v({"fuzzy", "fuzzy law of the descent, from height above the pad and sink rate"}, p.fuzzy);
}

void CheckFlight(const LandingFlight& flight, const Place& where, Mistakes& mistakes);
// A pad that is lost above the height at which it need no longer be seen.
void CheckFlightPad(const LandingFlight& flight, double seen_from_m, const Place& where, Mistakes& mistakes);
mission::MissionType TypeOf(const LandingFlight& flight);
// By any pilot.
std::unique_ptr<mission::Mission> MakeLanding(const LandingFlight& flight,
                                              std::unique_ptr<mission::Pilot> pilot);
std::unique_ptr<mission::Mission> MakeMission(const LandingFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
