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
  double manual_from_s = 1e9;
  double take_off_s = 0;  // the rotors run up until then
  double take_off_height_m = 5;
  ManoeuvreParameters manoeuvres;
  bool baseline = false;
  double baseline_px_per_deg = 2;
};

inline void Fields(FieldVisitor& v, AttitudeFlight& p) {
  v({"manual_from_s",
     "time from which a simulated pilot flies by hand; until then the autopilot holds the position"},
    p.manual_from_s, 0.0, 1e9);
  v({"take_off_s", "time of the take-off of a flight that begins on the ground; 0: it begins in the air"},
    p.take_off_s, 0.0, 1e6);
  v({"take_off_height_m", "height above the start that is climbed to after the take-off"},
    p.take_off_height_m, 1.0, 100.0);
  v({"manoeuvres", "what the simulated pilot flies by hand"}, p.manoeuvres);
  v({"baseline", "evaluate the thesis's own method on the same images too"}, p.baseline);
  v({"baseline_px_per_deg",
     "columns per degree of the panorama by which the thesis's method finds the heading (0.5 in thesis "
     "6.3.5)"},
    p.baseline_px_per_deg, 0.1, 20.0);
}

mission::MissionType TypeOf(const AttitudeFlight& flight);
bool FlightCanHave(const AttitudeFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const AttitudeFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
