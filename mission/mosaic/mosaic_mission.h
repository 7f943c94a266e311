// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mission/mission_type.h"
#include "mission/mosaic/mosaic_observer.h"
#include "mission/path/path_pilot.h"

namespace kestrel::mission {

// What flights that make a mosaic differ in.
struct MosaicFlight {
  vision::MosaicModel model = vision::MosaicModel::kPlane;
  vision::Surface surface = vision::Surface::kPlane;
  double height_m = 0;  // of the take-off
  PathParameters path;
  MosaicParameters mosaic;
  int images = 0;
  // The images are evenly spread over the time from when the second waypoint is left until the last is reached.
  PathPilot::Plan plan;
  std::string_view outcome;  // of one that was flown to its end
};

// Flies by the autopilot's own state, and makes the mosaic beside that.
std::unique_ptr<Mission> MakeMosaicMission(const MosaicFlight& flight, const MissionParts& parts);

// The type of such a mission without its plots: metrics and add_metrics are those beside what all of them have.
MissionType MosaicMissionType(
    const std::string& name, const std::string& summary, const std::vector<Metric>& metrics,
    const std::function<void(const std::vector<LogRow>&, std::map<std::string, double>&)>& add_metrics);

}  // namespace kestrel::mission
