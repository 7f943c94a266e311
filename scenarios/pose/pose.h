// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "mission/helipad_pilot.h"

namespace kestrel {

// Thesis 4.4.2: the aircraft hovers on its autopilot's own sensors, and the vision only estimates.
struct PoseFlight {
  static constexpr const char* kName = "pose";
  double height_m = 4.2;
};

template <class Visitor>
void Fields(Visitor& v, PoseFlight& p) {
  v("height_m", p.height_m, 0.3, 60.0);
}

std::unique_ptr<Mission> MakeMission(const PoseFlight& flight, HelipadPilot pilot);

}  // namespace kestrel
