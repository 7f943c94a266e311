// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

// Thesis 3.4: a camera is carried by hand through a room before a landmark on the wall, and the vision
// estimates where it is, image by image, without a filter and without an autopilot.
struct HandHeldFlight {
  bool chain = true;
};

inline void Fields(FieldVisitor& v, HandHeldFlight& p) {
  v({"chain", "also chain the homographies of the same images alone, as the thesis does"}, p.chain);
}

mission::MissionType TypeOf(const HandHeldFlight& flight);
void CheckFlightView(const HandHeldFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes);
bool FlightCanHave(const HandHeldFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const HandHeldFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
