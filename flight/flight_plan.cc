// SPDX-License-Identifier: Apache-2.0
#include "flight/flight_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "flight/check_mission.h"
#include "flight/gains_file.h"
#include "scenarios/flights.h"
#include "vision/camera/calibration_file.h"
#include "vision/image_file.h"
#include "vision/landmark/pad_file.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

// Leaves what the world's keys name out of a file; "image.*" with exceptions is written out key by key.
void PassOverWorld(ConfigNode& node, const std::string& path) {
  const auto& world = WorldKeys();
  std::erase_if(node.members, [&](const auto& member) {
    return std::find(world.begin(), world.end(), path + member.key) != world.end();
  });
  if (!path.empty()) return;
  for (auto& [key, member] : node.members) PassOverWorld(member, key + ".");
}

cv::Mat OwnParts(const FlightPlan& plan, const fs::path& beside, const vision::CameraModel& camera,
                 const Place& where, Mistakes& mistakes) {
  fs::path file = beside / plan.own_parts;
  if (plan.own_parts.empty()) {
    file = beside / "own_parts.png";
    if (!IsFile(file)) return cv::Mat::zeros(vision::HeightPx(camera), vision::WidthPx(camera), CV_8U);
  }
  const cv::Mat picture = vision::ReadMask(file, where, "own_parts", mistakes);
  if (!picture.empty() &&
      (picture.cols != vision::WidthPx(camera) || picture.rows != vision::HeightPx(camera)))
    mistakes.Add(
        where, "own_parts", fmt::format("'{}' has {} x {} pixels", file.string(), picture.cols, picture.rows),
        fmt::format("valid: the camera's {} x {}", vision::WidthPx(camera), vision::HeightPx(camera)));
  return picture;
}

LoadedPlan LoadWhole(const fs::path& file, const std::vector<std::string>& overrides) {
  Mistakes mistakes;
  const Place where = file.string();
  const fs::path beside = file.parent_path();
  scenarios::AddFlights();
  LoadedPlan loaded;
  FlightPlan& p = loaded.plan;
  Config config = LoadConfig(file, overrides, mistakes);
  loaded.description = config.description;
  CheckMissionExists(config, where, mistakes);
  PassOverWorld(config.root, "");
  PassOverGains(config);
  Read(config, p, mistakes);
  if (!config.readable) mistakes.ThrowIfAny();
  if (p.name.empty()) p.name = file.stem().string();
  CheckMission(p.flight, p.image.colour, config, where, mistakes);
  CheckPilot(p.flight, p.pilot, config, where, mistakes);

  mission::MissionParts& parts = loaded.parts;
  parts.pilot = p.pilot;
  parts.X_BC = vision::MountPose(p.mount);
  parts.seed = p.seed;
  if (const auto camera =
          ModelFile(Model::kCamera, p.camera, beside, WhereOf(config, "camera", where), mistakes)) {
    const std::size_t before = mistakes.all().size();
    parts.camera = vision::LoadCamera(*camera, mistakes, p.camera_name);
    if (mistakes.all().size() == before) {
      CheckView(p.flight, p.camera, parts.camera, p.mount, config, where, mistakes);
      parts.own_parts = OwnParts(p, beside, parts.camera, where, mistakes);
    }
  }
  parts.ground = LoadGroundSight(p.flight.type(), p.ground_camera, beside,
                                 WhereOf(config, "ground_camera", where), mistakes);
  if (p.pad.name == "none") {
    CheckHasPad(p.flight, config, where, mistakes);
  } else if (const auto pad =
                 ModelFile(Model::kPad, p.pad.name, beside, WhereOf(config, "pad", where), mistakes)) {
    parts.pad = vision::LoadPad(*pad, mistakes).reference;
  }
  mistakes.ThrowIfAny();
  return loaded;
}

}  // namespace

const std::vector<std::string_view>& WorldKeys() {
  static const std::vector<std::string_view> kKeys = {"vehicle",
                                                      "world",
                                                      "autopilot",
                                                      "platform",
                                                      "ground_view",
                                                      "actuators",
                                                      "landscape",
                                                      "deck",
                                                      "start",
                                                      "carry",
                                                      "render",
                                                      "wind",
                                                      "sensors",
                                                      "instruments",
                                                      "cameras",
                                                      "camera_error",
                                                      "event_camera",
                                                      "occlusion",
                                                      "targets",
                                                      "criteria",
                                                      "meshes",
                                                      "ground_photo",
                                                      "view",
                                                      "changeable",
                                                      "changes",
                                                      "pad.position_m",
                                                      "pad.print",
                                                      "pad.yaw_deg",
                                                      "pad.height_m",
                                                      "pad.tilt_deg",
                                                      "pad.uneven_deg",
                                                      "image.latency_s",
                                                      "image.exposure",
                                                      "image.lens",
                                                      "image.gain",
                                                      "image.auto_exposure",
                                                      "image.full_well_e",
                                                      "image.noise_grey",
                                                      "image.gamma",
                                                      "image.bits",
                                                      "image.jpeg_quality",
                                                      "image.scatter",
                                                      "image.faults"};
  return kKeys;
}

LoadedPlan LoadPlan(const std::string& name_or_file, const std::vector<std::string>& overrides) {
  const fs::path file = ScenarioFile(name_or_file);
  return LoadWithGains(file, overrides,
                       [&](const std::vector<std::string>& all) { return LoadWhole(file, all); });
}

}  // namespace kestrel::flight
