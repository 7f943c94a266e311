// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

// Thesis 4.4.2: the aircraft hovers on its autopilot's own sensors, and the vision only estimates.
struct PoseFlight {
  double height_m = 4.2;
};

inline void Fields(FieldVisitor& v, PoseFlight& p) {
  v({"height_m", "height above the autopilot's local origin at which the aircraft hovers"}, p.height_m, 0.3,
    60.0);
}

mission::MissionType TypeOf(const PoseFlight& flight);
std::unique_ptr<mission::Mission> MakeMission(const PoseFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
