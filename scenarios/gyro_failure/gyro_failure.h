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
  double disagree_deg = 3;  // between both attitudes, beyond what is usual: the own one is wrong
  double agree_deg = 2;     // it is right again if it keeps its distance to the camera's to this,
  double agree_s = 3;       // for so long
  double coast_s = 5;       // without a skyline for which the gyros alone may carry the camera's attitude on
};

inline void Fields(FieldVisitor& v, GyroFailureFlight& p) {
  v("disagree_deg", p.disagree_deg, 0.5, 30.0);
  v("agree_deg", p.agree_deg, 0.1, 30.0);
  v("agree_s", p.agree_s, 0.1, 60.0);
  v("coast_s", p.coast_s, 0.1, 60.0);
}

mission::MissionType TypeOf(const GyroFailureFlight& flight);
bool FlightCanHave(const GyroFailureFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const GyroFailureFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
