// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "mission/mission_type.h"
#include "scenarios/attitude/manual_pilot.h"
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {

// Thesis 6.3.5: the attitude from the skyline and the heading from the visual compass, frame by frame, while
// the autopilot hovers or a pilot flies by hand.
struct AttitudeFlight {
  double manual_from_s = 1e9;  // until then the autopilot holds the place
  double take_off_s = 0;       // of a flight that begins on the ground: the rotors run up until then
  double take_off_height_m = 5;
  ManoeuvreParameters manoeuvres;
  bool baseline = false;  // the thesis's own method too, on the same images
};

inline void Fields(FieldVisitor& v, AttitudeFlight& p) {
  v("manual_from_s", p.manual_from_s, 0.0, 1e9);
  v("take_off_s", p.take_off_s, 0.0, 1e6);
  v("take_off_height_m", p.take_off_height_m, 1.0, 100.0);
  v("manoeuvres", p.manoeuvres);
  v("baseline", p.baseline);
}

mission::MissionType TypeOf(const AttitudeFlight& flight);
bool FlightCanHave(const AttitudeFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const AttitudeFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
