// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/path/waypoint_path.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"

namespace kestrel::scenarios {

// Thesis 4.2: the video of a camera that shakes is stabilised on board, while the aircraft hovers, flies on and
// hovers again.
struct StabiliseFlight {
  double height_m = 15;
  double hover_s = 8;
  double transit_m = 40;
  mission::PathParameters path;
  vision::StabiliserOptions stabiliser;
};

inline void Fields(FieldVisitor& v, StabiliseFlight& p) {
  v({"height_m", "height above the autopilot's local origin"}, p.height_m, 2.0, 500.0);
  v({"hover_s", "time of hovering before and after the transit"}, p.hover_s, 1.0, 600.0);
  v({"transit_m", "length of the transit, straight ahead"}, p.transit_m, 0.0, 5000.0);
  v({"path", "speeds and gains of the path"}, p.path);
  v({"stabiliser", "stabilisation of the video"}, p.stabiliser);
}

mission::MissionType TypeOf(const StabiliseFlight& flight);
void CheckFlight(const StabiliseFlight& flight, const Place& where, Mistakes& mistakes);
void CheckFlightLimits(const StabiliseFlight& flight, const mission::AircraftLimits& limits,
                       const Place& where, Mistakes& mistakes);
std::unique_ptr<mission::Mission> MakeMission(const StabiliseFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
