// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

// Thesis 5.3.1, landing control: centre, descend over the pad, and below a height sink at a constant speed.
// It lands on a pad that it sees and on no other place: lost above blind_m, it stops, climbs and searches.
struct LandingFlight {
  double yaw_deg = 0;        // in the pad's frame
  double descent_m_s = 0.7;  // greatest speed of the descent
  double commit_m = 0.7;     // height below which the aircraft sinks at a constant speed
  double commit_sink_m_s = 0.2;
  double blind_m = 0.35;    // height below which it goes on without seeing the pad
  double centred_m = 0.12;  // horizontal error, plus a tenth of the height, up to which it descends
};

inline void Fields(FieldVisitor& v, LandingFlight& p) {
  v("yaw_deg", p.yaw_deg, -180.0, 180.0);
  v("descent_m_s", p.descent_m_s, 0.1, 3.0);
  v("commit_m", p.commit_m, 0.1, 5.0);
  v("commit_sink_m_s", p.commit_sink_m_s, 0.15, 1.0);
  v("blind_m", p.blind_m, 0.0, 2.0);
  v("centred_m", p.centred_m, 0.01, 2.0);
}

mission::MissionType TypeOf(const LandingFlight& flight);
std::unique_ptr<mission::Mission> MakeMission(const LandingFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
