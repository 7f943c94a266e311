// SPDX-License-Identifier: Apache-2.0
#include "scenarios/ground/ground_flights.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mission/ground/ground_pilot.h"

namespace kestrel::scenarios {
namespace {

using mission::LogRow;

constexpr const char* kVideo = "ground.mp4";

double Share(const std::vector<LogRow>& rows, std::initializer_list<std::string_view> targets) {
  const auto count = std::count_if(rows.begin(), rows.end(), [&](const LogRow& row) {
    return std::find(targets.begin(), targets.end(), row.decision.target) != targets.end();
  });
  return rows.empty() ? 0 : static_cast<double>(count) / static_cast<double>(rows.size());
}

mission::MissionType ByGround(mission::MissionType type) {
  type.looks_for_pad = false;
  type.needs_ground_camera = true;
  type.product_video = kVideo;
  return type;
}

}  // namespace

mission::MissionType TypeOf(const HoverGroundFlight&) {
  mission::MissionType type = ByGround(TypeOf(HoverFlight{}));
  type.name = "hover_ground_camera";
  type.summary = "Hovers over the pad by what a camera on the ground sees of the aircraft.";
  return type;
}

mission::MissionType TypeOf(const LandingGroundFlight&) {
  mission::MissionType type = ByGround(TypeOf(LandingFlight{}));
  type.name = "landing_ground_camera";
  type.summary = "Lands on the pad by what a camera on the ground sees of the aircraft.";
  return type;
}

mission::MissionType TypeOf(const LandingHybridFlight&) {
  mission::MissionType type = ByGround(TypeOf(LandingFlight{}));
  type.name = "landing_hybrid";
  type.summary =
      "Lands on the pad by a camera on board and one on the ground, by either when one is blocked.";
  type.looks_for_pad = true;
  type.metrics.push_back(
      {"by_board_alone_share", "1", "Share of images in which only the camera on board measured", 0, 1});
  type.metrics.push_back({"by_ground_alone_share", "1",
                          "Share of images in which only the camera on the ground measured", 0, 1});
  type.add_metrics = [of_landing = type.add_metrics](const std::vector<LogRow>& rows,
                                                     std::map<std::string, double>& metrics) {
    if (of_landing) of_landing(rows, metrics);
    metrics["by_board_alone_share"] = Share(rows, {"board", "board, clock"});
    metrics["by_ground_alone_share"] = Share(rows, {"ground"});
  };
  return type;
}

std::unique_ptr<mission::Mission> MakeMission(const HoverGroundFlight& flight,
                                              const mission::MissionParts& parts) {
  return MakeHover(flight, std::make_unique<mission::GroundPilot>(parts, false));
}

std::unique_ptr<mission::Mission> MakeMission(const LandingGroundFlight& flight,
                                              const mission::MissionParts& parts) {
  return MakeLanding(flight, std::make_unique<mission::GroundPilot>(parts, false));
}

std::unique_ptr<mission::Mission> MakeMission(const LandingHybridFlight& flight,
                                              const mission::MissionParts& parts) {
  return MakeLanding(flight, std::make_unique<mission::GroundPilot>(parts, true));
}

}  // namespace kestrel::scenarios
