// SPDX-License-Identifier: Apache-2.0
#include "scenarios/survey/survey.h"

#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/mosaic/mosaic_mission.h"
#include "mission/path/path_records.h"
#include "records/plot/growth_plot.h"
#include "records/plot/path_plot.h"
#include "scenarios/survey/survey_metrics.h"

namespace kestrel::scenarios {
namespace {

constexpr double kSettle_s = 2;  // at the beginning of the first line

}  // namespace

std::vector<mission::Waypoint> SurveyLines(const SurveyFlight& flight, const Eigen::Vector3d& p_N,
                                           double yaw) {
  const double heading = Radians(flight.heading_deg);
  const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0), right(-along.y(), along.x(), 0);
  const Eigen::Vector3d begin(flight.begin_m.x(), flight.begin_m.y(), -flight.height_m);
  const double turned = yaw + WrapAngle(heading - yaw);
  std::vector<mission::Waypoint> path = {{p_N, yaw, 0, "approach"}, {begin, turned, kSettle_s, "approach"}};
  for (int line = 0; line < flight.lines; ++line) {
    const bool out = line % 2 == 0;
    const Eigen::Vector3d first = begin + line * flight.spacing_m * right;
    const Eigen::Vector3d far = first + flight.line_m * along;
    if (line > 0) path.push_back({out ? first : far, turned, 0, "shift"});
    path.push_back({out ? far : first, turned, 0, "line"});
  }
  path.back().hold_s = kSettle_s;
  return path;
}

mission::MissionType TypeOf(const SurveyFlight&) {
  mission::MissionType type =
      mission::MosaicMissionType("survey", "Flies over the ground in lines while a mosaic of it grows.",
                                 SurveyMetrics(), AddSurveyMetrics);
  type.plots = {{"path.png", records::FliesPath, records::PathPlot},
                {"growth.png", records::MakesMosaic, records::GrowthPlot}};
  return type;
}

void CheckFlightLimits(const SurveyFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes) {
  mission::CheckPathLimits(flight.path, limits, where, mistakes);
}

bool FlightCanHave(const SurveyFlight& flight, const std::string& metric, const mission::Varies& varies) {
  if (metric.starts_with("chain_")) return flight.mosaic.chain || varies("flight.mosaic.chain");
  if (metric == "georeference_rmse_m") return flight.mosaic.poses || varies("flight.mosaic.poses");
  return true;
}

std::unique_ptr<mission::Mission> MakeMission(const SurveyFlight& flight,
                                              const mission::MissionParts& parts) {
  return mission::MakeMosaicMission(
      {.height_m = flight.height_m,
       .path = flight.path,
       .mosaic = flight.mosaic,
       .images = flight.images,
       .plan = [flight](const Eigen::Vector3d& p_N, double yaw) { return SurveyLines(flight, p_N, yaw); },
       .outcome = "surveyed"},
      parts);
}

}  // namespace kestrel::scenarios
