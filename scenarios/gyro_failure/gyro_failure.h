// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "mission/mission_type.h"
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {

// What thesis 6.3 proposes the skyline for, a second source of the attitude: the aircraft holds its place and
// heading; when the autopilot's own attitude goes silent, freezes, or parts from what the camera sees, the
// camera's takes its place, until the own one is back and has agreed with it for a while.
struct GyroFailureFlight {
  double disagree_deg = 3;
  double agree_deg = 2;
  double agree_s = 3;
  double coast_s = 5;
};

inline void Fields(FieldVisitor& v, GyroFailureFlight& p) {
  v({"disagree_deg",
     "angle between the autopilot's attitude and the camera's, beyond the usual, from which the autopilot's "
     "is wrong"},
    p.disagree_deg, 0.5, 30.0);
  v({"agree_deg",
     "maximum change in the rotation between both attitudes with which the autopilot's is right again"},
    p.agree_deg, 0.1, 30.0);
  v({"agree_s", "time for which the autopilot's attitude must keep to agree_deg before it is used again"},
    p.agree_s, 0.1, 60.0);
  v({"coast_s", "longest time without a skyline for which gyros alone may carry the camera's attitude on"},
    p.coast_s, 0.1, 60.0);
}

mission::MissionType TypeOf(const GyroFailureFlight& flight);
bool FlightCanHave(const GyroFailureFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const GyroFailureFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
