// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/mosaic/mosaic_observer.h"
#include "mission/path/waypoint_path.h"

namespace kestrel::scenarios {

// Thesis 4.3, figures 4.6 and 4.8: the ground in lines, back and forth, while a mosaic of it grows.
struct SurveyFlight {
  double height_m = 60;
  Eigen::Vector2d begin_m{-40, -40};
  double heading_deg = 0;
  int lines = 3;
  double line_m = 80, spacing_m = 40;
  int images = 450;
  mission::PathParameters path;
  mission::MosaicParameters mosaic;
};

inline void Fields(FieldVisitor& v, SurveyFlight& p) {
  v({"height_m", "height above the autopilot's local origin, which is taken for that of the ground"},
    p.height_m, 2.0, 500.0);
  v({"begin_m", "where the first line begins: north and east of the autopilot's local origin"}, p.begin_m,
    -1e4, 1e4);
  v({"heading_deg", "direction of the first line, and heading of the aircraft on all of them"}, p.heading_deg,
    -360.0, 360.0);
  v({"lines", "number of lines, each to the right of the one before and flown the other way"}, p.lines, 1,
    100);
  v({"line_m", "length of a line"}, p.line_m, 1.0, 5000.0);
  v({"spacing_m", "distance of two lines"}, p.spacing_m, 0.5, 500.0);
  v({"images", "images of the mosaic, evenly spread over the time of the lines"}, p.images, 2, 10000);
  v({"path", "speeds and gains of the path"}, p.path);
  v({"mosaic", "the mosaic"}, p.mosaic);
}

mission::MissionType TypeOf(const SurveyFlight& flight);
void CheckFlightLimits(const SurveyFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes);
bool FlightCanHave(const SurveyFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const SurveyFlight& flight, const mission::MissionParts& parts);

// The way of the lines from where the aircraft is.
std::vector<mission::Waypoint> SurveyLines(const SurveyFlight& flight, const Eigen::Vector3d& p_N,
                                           double yaw);

}  // namespace kestrel::scenarios
