// SPDX-License-Identifier: Apache-2.0
#include "scenarios/panorama/panorama.h"

#include "geometry/tait_bryan.h"
#include "mission/mosaic/mosaic_mission.h"
#include "mission/path/path_records.h"
#include "records/plot/growth_plot.h"
#include "records/plot/path_plot.h"
#include "scenarios/panorama/panorama_metrics.h"

namespace kestrel::scenarios {
namespace {

constexpr double kSettle_s = 3;  // before the turn, and after it

std::vector<mission::Waypoint> Turn(const PanoramaFlight& flight, const Eigen::Vector3d& p_N, double yaw) {
  const Eigen::Vector3d spot(p_N.x(), p_N.y(), -flight.height_m);
  return {{p_N, yaw, 0, "approach"},
          {spot, yaw, kSettle_s, "hover"},
          {spot, yaw + Radians(flight.turn_deg), kSettle_s, "turn"}};
}

}  // namespace

mission::MissionType TypeOf(const PanoramaFlight&) {
  mission::MissionType type = mission::MosaicMissionType(
      "panorama", "Turns on the spot while a panorama of all that is around grows.", PanoramaMetrics(),
      AddPanoramaMetrics);
  type.plots = {{"path.png", records::FliesPath, records::PathPlot},
                {"growth.png", records::MakesMosaic, records::GrowthPlot}};
  return type;
}

void CheckFlightLimits(const PanoramaFlight& flight, const mission::AircraftLimits& limits,
                       const Place& where, Mistakes& mistakes) {
  mission::CheckPathLimits(flight.path, limits, where, mistakes);
}

bool FlightCanHave(const PanoramaFlight& flight, const std::string& metric, const mission::Varies& varies) {
  if (metric == "panorama_closure_deg") return flight.turn_deg >= 360 || varies("flight.turn_deg");
  if (metric.starts_with("chain_"))
    return (flight.mosaic.chain || varies("flight.mosaic.chain")) &&
           (metric != "chain_closure_deg" || flight.turn_deg >= 360 || varies("flight.turn_deg"));
  return true;
}

std::unique_ptr<mission::Mission> MakeMission(const PanoramaFlight& flight,
                                              const mission::MissionParts& parts) {
  return mission::MakeMosaicMission(
      {.model = vision::MosaicModel::kRotation,
       .surface = vision::Surface::kSphere,
       .height_m = flight.height_m,
       .path = flight.path,
       .mosaic = flight.mosaic,
       .images = flight.images,
       .plan = [flight](const Eigen::Vector3d& p_N, double yaw) { return Turn(flight, p_N, yaw); },
       .outcome = "turned"},
      parts);
}

}  // namespace kestrel::scenarios
