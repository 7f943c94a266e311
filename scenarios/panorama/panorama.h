// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/mosaic/mosaic_observer.h"
#include "mission/path/waypoint_path.h"

namespace kestrel::scenarios {

// Thesis 4.3: a turn on the spot, and a spherical mosaic of all that is around.
struct PanoramaFlight {
  double height_m = 60;
  double turn_deg = 390;
  int images = 260;
  mission::PathParameters path;
  mission::MosaicParameters mosaic;
};

inline void Fields(FieldVisitor& v, PanoramaFlight& p) {
  v({"height_m", "height above the autopilot's local origin"}, p.height_m, 2.0, 500.0);
  v({"turn_deg", "how far the aircraft turns, clockwise; more than a whole turn closes the panorama"},
    p.turn_deg, 10.0, 1440.0);
  v({"images", "images of the panorama, evenly spread over the time of the turn"}, p.images, 2, 10000);
  v({"path", "rates and gains of the turn"}, p.path);
  v({"mosaic", "the mosaic"}, p.mosaic);
}

mission::MissionType TypeOf(const PanoramaFlight& flight);
void CheckFlightLimits(const PanoramaFlight& flight, const mission::AircraftLimits& limits,
                       const Place& where, Mistakes& mistakes);
bool FlightCanHave(const PanoramaFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const PanoramaFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
