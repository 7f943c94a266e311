// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

// Finds where the camera on the ground stands: flies about over the pad by what the camera on board sees of it, while
// the other watches. Of its place only as much needs to be known as lets it see the aircraft.
struct GroundCalibrationFlight {
  double reach_m = 0.9;
  double low_m = 3, high_m = 5;
  double yaw_deg = 0;
  double reached_m = 0.3;
  int laps = 2;
};

inline void Fields(FieldVisitor& v, GroundCalibrationFlight& p) {
  v({"reach_m", "how far to each side of the pad's middle the corners of the flight are"}, p.reach_m, 0.2,
    20.0);
  v({"low_m", "height of its lower corners above the pad"}, p.low_m, 0.5, 50.0);
  v({"high_m", "height of its upper corners above the pad"}, p.high_m, 0.5, 50.0);
  v({"yaw_deg", "heading to hold, clockwise from the top of the pad's picture"}, p.yaw_deg, -180.0, 180.0);
  v({"laps", "how often it flies round them"}, p.laps, 1, 100);
  v({"reached_m", "distance from a corner at which it goes on to the next"}, p.reached_m, 0.05, 5.0);
}

void CheckFlight(const GroundCalibrationFlight& flight, const Place& where, Mistakes& mistakes);
mission::MissionType TypeOf(const GroundCalibrationFlight& flight);
std::unique_ptr<mission::Mission> MakeMission(const GroundCalibrationFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
