// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/pilot.h"

namespace kestrel::scenarios {

// Thesis 5.3.1, positioning control: centre over the pad first, then go to the height.
struct HoverFlight {
  double height_m = 3;
  double centred_m = 0.5;
  double yaw_deg = 0;
};

inline void Fields(FieldVisitor& v, HoverFlight& p) {
  v({"height_m", "height above the pad at which the aircraft hovers"}, p.height_m, 0.3, 60.0);
  v({"centred_m", "horizontal error below which the aircraft goes to its height"}, p.centred_m, 0.05, 5.0);
  v({"yaw_deg", "heading to hold, clockwise from the top of the pad's picture"}, p.yaw_deg, -180.0, 180.0);
}

mission::MissionType TypeOf(const HoverFlight& flight);
// By any pilot.
std::unique_ptr<mission::Mission> MakeHover(const HoverFlight& flight, std::unique_ptr<mission::Pilot> pilot);
std::unique_ptr<mission::Mission> MakeMission(const HoverFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
