// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

// Thesis 5.3.1, positioning control: centre over the pad first, then go to the height.
struct HoverFlight {
  double height_m = 3;
  double centred_m = 0.5;  // horizontal error under which the height follows
  double yaw_deg = 0;      // in the pad's frame
};

inline void Fields(FieldVisitor& v, HoverFlight& p) {
  v("height_m", p.height_m, 0.3, 60.0);
  v("centred_m", p.centred_m, 0.05, 5.0);
  v("yaw_deg", p.yaw_deg, -180.0, 180.0);
}

mission::MissionType TypeOf(const HoverFlight& flight);
std::unique_ptr<mission::Mission> MakeMission(const HoverFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
