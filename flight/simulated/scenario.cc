// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/gravity.h"
#include "base/random.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "flight/check_mission.h"
#include "flight/flight_subject.h"
#include "flight/gains_file.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/check/check_ground.h"
#include "flight/simulated/check/check_image.h"
#include "flight/simulated/possible_metrics.h"
#include "flight/simulated/world_of.h"
#include "geometry/tait_bryan.h"
#include "records/telemetry/metrics.h"
#include "scenarios/flights.h"
#include "sim/camera/skyline/horizon.h"
#include "sim/vehicle_file.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

// The numbers of a vehicle, whose shape lies beside them. Where there is no such vehicle nobody says so yet.
fs::path VehicleFile(std::string vehicle, const fs::path& beside) {
  Mistakes none;
  const auto file = ModelFile(Model::kVehicle, vehicle, beside, "", none);
  return file ? fs::path(*file).replace_extension(".yaml") : fs::path();
}

// What of a scenario and a landscape does not go together. world: as its file has it.
void CheckLandscape(const Scenario& s, const LoadedWorld& world, const Config& config, const Place& where,
                    Mistakes& mistakes) {
  if (world.landscape) {
    if (s.render.backend != "auto" && s.render.backend != "ray") {
      mistakes.Add(WhereOf(config, "render", where), "render.backend",
                   fmt::format("'{}' draws to 500 m alone, and the world '{}' reaches beyond its horizon",
                               s.render.backend, s.world),
                   "valid: ray");
    }
  } else if (s.landscape) {
    mistakes.Add(WhereOf(config, "landscape", where), "landscape",
                 fmt::format("the world '{}' is not made from numbers; worlds that are: {}", s.world,
                             fmt::join(LandscapeNames(), ", ")));
  }
}

void CheckTargets(const Scenario& s, const Place& where, Mistakes& mistakes) {
  constexpr std::size_t kMost = 200;  // MuJoCo's own memory for a step ends below 2000
  if (s.targets.size() > kMost)
    return mistakes.Add(where, "targets", fmt::format("there are {}", s.targets.size()),
                        fmt::format("valid: up to {}", kMost));
  for (std::size_t i = 0; i < s.targets.size(); ++i) {
    const sim::TargetParameters& t = s.targets[i];
    const std::string name = fmt::format("targets[{}]", i);
    if ((t.velocity_m_s.norm() > 0) + (t.string_m > 0) + (t.roam_m_s > 0) > 1)
      mistakes.Add(where, name, "moves in several ways", "valid: one of velocity_m_s, string_m and roam_m_s");
    const double lowest_m = t.position_m.z() - t.diameter_m / 2 - t.string_m;
    if (lowest_m < 0)
      mistakes.Add(where, name + ".position_m",
                   fmt::format("with its diameter and string it reaches {:.3g} m into the ground", -lowest_m),
                   fmt::format("valid: a height from {:.3g} m", t.position_m.z() - lowest_m));
  }
}

// Where a deck begins, and what carries it.
void CheckDeckPlace(const Scenario& s, const Config& config, const Place& file, Mistakes& mistakes) {
  constexpr double kRoom_m = 0.25;  // for its plate
  const Place where = WhereOf(config, "deck", file), pad = WhereOf(config, "pad", file);
  sim::CheckDeck(*s.deck, s.autopilot.speed_limit_m_s, s.autopilot.acceleration_limit_m_s2, where, mistakes);
  for (const auto& [key, value] :
       {std::pair{"pad.tilt_deg", s.pad.tilt_deg}, {"pad.uneven_deg", s.pad.uneven_deg}})
    if (value != 0)
      mistakes.Add(pad, key, fmt::format("{:g}, but a deck is level at rest", value),
                   "valid: 0, or deck: null");
  if (s.pad.height_m < kRoom_m)
    mistakes.Add(pad, "pad.height_m", fmt::format("{:g} leaves no room for the deck below", s.pad.height_m),
                 fmt::format("valid: from {:g} on", kRoom_m));
  if (s.start.on_ground)
    mistakes.Add(WhereOf(config, "start", file), "start.on_ground", "true, on a deck that moves",
                 "valid: false, or deck: null");
}

// Where a criterion was written; file: where none was.
Place WhereOfCriterion(const Config& config, const std::string& metric, const Place& file) {
  const ConfigNode* criteria = Find(config, "criteria");
  if (!criteria) return file;
  for (const auto& [name, member] : criteria->members)
    if (name == metric) return member.where;
  return criteria->where;
}

// Limits that leave nothing between them, or nothing of what a metric can be.
void CheckLimit(const mission::Metric& metric, const Limit& limit, const Place& where, Mistakes& mistakes) {
  const std::string key = "criteria." + metric.name;
  const bool has_high = std::isfinite(metric.high);
  const std::string valid = has_high ? fmt::format("valid: {:g} to {:g}", metric.low, metric.high)
                                     : fmt::format("valid: {:g} or more", metric.low);
  if (!limit.max && !limit.min) mistakes.Add(where, key, "has no limit", "valid: max, min or both");
  if (limit.max && limit.min && *limit.min > *limit.max)
    mistakes.Add(
        where, key,
        fmt::format("min = {:g} is above max = {:g}, so that no flight meets both", *limit.min, *limit.max),
        "valid: min no more than max");
  if (limit.max && *limit.max < metric.low)
    mistakes.Add(
        where, key + ".max",
        fmt::format("{:g} is met by no flight, as the metric is never below {:g}", *limit.max, metric.low),
        valid);
  if (limit.min && *limit.min > metric.high)
    mistakes.Add(
        where, key + ".min",
        fmt::format("{:g} is met by no flight, as the metric is never above {:g}", *limit.min, metric.high),
        valid);
}

// What a flight of this scenario cannot have is "not reached" by every flight: the criterion is a mistake.
void CheckCriteria(const Scenario& s, const Config& config, const Place& file, Mistakes& mistakes) {
  const std::vector<mission::Metric> all = records::AllMetrics();
  const std::vector<std::string> possible = PossibleMetrics(s);
  for (const auto& [metric, limit] : s.criteria) {
    const std::string key = "criteria." + metric;
    const Place where = WhereOfCriterion(config, metric, file);
    if (!Known("metric", metric, NamesOf(all), where, mistakes)) continue;
    if (std::find(possible.begin(), possible.end(), metric) == possible.end())
      mistakes.Add(
          where, key,
          fmt::format("a flight of this scenario, of the mission '{}', has no '{}'", s.mission, metric),
          fmt::format("valid: {}", fmt::join(possible, ", ")));
    CheckLimit(*std::find_if(all.begin(), all.end(),
                             [&metric = metric](const auto& each) { return each.name == metric; }),
               limit, where, mistakes);
  }
}

// A root mean square over an image or two is no figure, and passes or fails by chance.
void CheckFrames(const Scenario& s, const Place& where, Mistakes& mistakes) {
  constexpr double kFewestFrames = 10;
  const double frames = s.duration_s * s.image.rate_hz;
  if (s.criteria.empty() || frames >= kFewestFrames - 1e-9) return;
  mistakes.Add(where, "image.rate_hz",
               fmt::format("{:g} gives {:.0f} images in duration_s = {:g}, too few to judge a flight by",
                           s.image.rate_hz, std::floor(frames), s.duration_s),
               fmt::format("valid: at least {:.3g}, a longer duration_s, or no criteria",
                           kFewestFrames / s.duration_s));
}

// Whether an aircraft can carry its own weight.
void CheckLift(const sim::AirframeParameters& vehicle, const Place& where, Mistakes& mistakes) {
  const double mass = sim::Mass_kg(vehicle), weight = mass * kGravity_m_s2,
               thrust = sim::MaxThrust_n(vehicle);
  if (thrust < 1.2 * weight) {
    mistakes.Add(
        where, "mass_kg",
        fmt::format("{} weighs {:.3g} N, and the rotors give {:.3g} N at most", mass, weight, thrust),
        "valid: a fifth more than the weight");
  }
  const auto* helicopter = std::get_if<sim::HelicopterParameters>(&vehicle);
  if (helicopter && sim::HoverPower_w(*helicopter) > 0.9 * helicopter->drive.power_w) {
    mistakes.Add(where, "drive.power_w",
                 fmt::format("{:g} W, and hovering takes {:.0f} W", helicopter->drive.power_w,
                             sim::HoverPower_w(*helicopter)),
                 "valid: a ninth more than that");
  }
}

// What a list of rotors cannot do. where: of the list.
void CheckRotors(const sim::AirframeParameters& vehicle, const Place& where, Mistakes& mistakes) {
  const auto* multirotor = std::get_if<sim::MultirotorParameters>(&vehicle);
  if (!multirotor || multirotor->rotors.empty()) return;
  if (multirotor->rotors.size() > sim::kMaxRotors) {
    mistakes.Add(where, "rotors", fmt::format("has {}", multirotor->rotors.size()),
                 fmt::format("valid: 4 to {}", sim::kMaxRotors));
  } else if (const auto why = sim::CannotFly(sim::LayoutOf(*multirotor), sim::LimitsOf(multirotor->rotor),
                                             multirotor->mass_kg * kGravity_m_s2)) {
    mistakes.Add(where, "rotors", *why,
                 "valid: 4 or more about the centre of mass, half of them of each spin");
  }
}

// The keys of a mount that is still.
std::string MountText(const Pose& X_BC) {
  const TaitBryan turn =
      TaitBryanFromRotation((X_BC.R * vision::MountPose({}).R.inverse()).toRotationMatrix());
  const auto rounded = [](double value, double to) { return std::round(value / to) * to + 0.0; };  // no -0
  return fmt::format(
      "{{position_m: [{:.3f}, {:.3f}, {:.3f}], yaw_deg: {:.2f}, pitch_deg: {:.2f}, roll_deg: {:.2f}}}",
      rounded(X_BC.p.x(), 1e-3), rounded(X_BC.p.y(), 1e-3), rounded(X_BC.p.z(), 1e-3),
      rounded(Degrees(turn.yaw), 1e-2), rounded(Degrees(turn.pitch), 1e-2),
      rounded(Degrees(turn.roll), 1e-2));
}

std::vector<std::string> NotesOn(const Scenario& s, const vision::CameraModel& camera) {
  std::vector<std::string> notes;
  if (const double covered = vision::ShareCovered(camera); covered < 1) {
    notes.push_back(fmt::format(
        "the camera '{}' fills {:.0f} % of its image, to {:.4g} deg from its axis; the rest is black",
        s.camera, 100 * covered, Degrees(vision::MaxAngle(camera))));
  }
  Mistakes none;
  const auto file = s.camera.find('/') == std::string::npos ? std::nullopt : std::optional(s.camera);
  const auto names = file ? vision::CameraNames(LoadConfig(*file, {}, none)) : std::vector<std::string>();
  if (names.size() > 1) {
    notes.push_back(fmt::format("the camera is {} of '{}', which has {}",
                                s.camera_name.empty() ? names.front() : s.camera_name, s.camera,
                                fmt::join(names, ", ")));
  }
  if (file) {
    Mistakes mistakes;
    if (const auto X_IC = vision::LoadPoseOnImu(*file, mistakes, s.camera_name)) {
      const Eigen::Quaterniond R_BI(0, 1, 0, 0);  // from forward, left, up
      notes.push_back(fmt::format(
          "'{}' says where the camera is on its IMU, which is the mount if the IMU stands on the aircraft's "
          "centre: mount: {} with its axes forward, right, down; mount: {} with forward, left, up; the "
          "flight has mount: {}",
          s.camera, MountText(*X_IC), MountText(Pose{R_BI, Eigen::Vector3d::Zero()} * *X_IC),
          MountText(vision::MountPose(s.mount))));
    }
    for (const std::string& text : mistakes.Texts()) notes.push_back(text);
  }
  return notes;
}

LoadedScenario LoadWhole(const fs::path& file, const std::vector<std::string>& overrides, bool compile) {
  Mistakes mistakes;
  const fs::path beside = file.parent_path();
  scenarios::AddFlights();
  LoadedScenario loaded;
  Scenario& s = loaded.scenario;
  Config config = LoadConfig(file, overrides, mistakes);
  loaded.description = config.description;
  CheckMissionExists(config, file.string(), mistakes);
  RenameFormerMetrics(config, {"criteria"});
  PassOverGains(config);
  const ConfigNode* world_named = Find(config, "world");
  const auto world = WorldOf(world_named ? world_named->text : s.world, beside, mistakes);
  if (world) s.landscape = world->landscape;
  const ConfigNode* named = Find(config, "vehicle");
  const fs::path vehicle_file = VehicleFile(named ? named->text : s.vehicle, beside);
  sim::VehicleFile vehicle;
  Config vehicle_config;
  if (IsFile(vehicle_file)) {
    vehicle_config = LoadConfig(vehicle_file, {}, mistakes);
    Read(vehicle_config, vehicle, mistakes);
    CheckRotors(vehicle.airframe, WhereOf(vehicle_config, "rotors", vehicle_file.string()), mistakes);
  }
  s.autopilot = vehicle.autopilot;
  s.platform = vehicle.platform;
  const auto imu = ImuOfFile(config, beside, mistakes);
  s.instruments.imu = imu;
  Read(config, s, mistakes);
  if (world && !s.landscape) s.landscape = world->landscape;  // it was given without a word
  if (imu && s.instruments.imu) s.instruments.imu->file = imu->file;
  if (!config.readable) mistakes.ThrowIfAny();
  if (s.name.empty()) s.name = file.stem().string();
  const Place where = file.string();
  if (!NamesFolder(s.name)) {
    mistakes.Add(WhereOf(config, "name", where), "name", fmt::format("'{}' cannot name a folder", s.name),
                 "valid: no slash, no leading dot, no control character");
  }
  constexpr std::size_t kLongestName = 200;  // with the seed or the time it names a folder, of 255 bytes
  if (s.name.size() > kLongestName)
    mistakes.Add(WhereOf(config, "name", where), "name", fmt::format("has {} bytes", s.name.size()),
                 fmt::format("valid: up to {}", kLongestName));
  if (s.flight.type().begins_in_the_air && s.start.on_ground) {
    mistakes.Add(WhereOf(config, "start", where), "start.on_ground",
                 fmt::format("true, but the mission '{}' begins in the air", s.mission), "valid: false");
  }
  if (s.occlusion.until_s <= s.occlusion.from_s) {
    mistakes.Add(WhereOf(config, "occlusion", where), "occlusion.until_s",
                 fmt::format("{} is not after from_s = {}", s.occlusion.until_s, s.occlusion.from_s));
  }
  CheckNumbers(s, vehicle.airframe, config, where, mistakes);
  if (s.deck) CheckDeckPlace(s, config, where, mistakes);
  if (s.carry) sim::CheckCarry(*s.carry, WhereOf(config, "carry", where), mistakes);
  if (world) CheckLandscape(s, *world, config, where, mistakes);
  FindAdditions(s.meshes, s.ground_photo, beside, config, where, mistakes);
  CheckMount(s.mount, WhereOf(config, "mount", where), mistakes);
  CheckCriteria(s, config, where, mistakes);
  CheckFrames(s, WhereOf(config, "image", where), mistakes);

  sim::SimulatorParameters& sim = loaded.simulator;
  if (const auto shape =
          ModelFile(Model::kVehicle, s.vehicle, beside, WhereOf(config, "vehicle", where), mistakes))
    sim.scene.vehicle = fs::path(*shape).replace_extension(".xml");
  if (const auto* drawn = std::get_if<sim::MultirotorParameters>(&vehicle.airframe);
      drawn && !drawn->rotors.empty() && !IsFile(sim.scene.vehicle))
    sim.scene.vehicle_shape = sim::MultirotorShape(*drawn);
  sim.vehicle = vehicle.airframe;
  sim.autopilot = s.autopilot;
  if (ModelFile(Model::kWorld, s.world, beside, WhereOf(config, "world", where), mistakes) && world) {
    sim.scene.world = world->file;
    sim.scene.landscape = s.landscape;
    sim.scene.seed = s.seed;
    sim.scene.additions = world->additions;
    sim.scene.additions.meshes.insert(sim.scene.additions.meshes.end(), s.meshes.begin(), s.meshes.end());
    if (s.ground_photo) sim.scene.additions.ground_photo = s.ground_photo;
  }
  bool has_camera = false;
  if (const auto camera =
          ModelFile(Model::kCamera, s.camera, beside, WhereOf(config, "camera", where), mistakes)) {
    const std::size_t before = mistakes.all().size();
    sim.camera = vision::LoadCamera(*camera, mistakes, s.camera_name);
    has_camera = mistakes.all().size() == before;
    if (has_camera) CheckView(s.flight, s.camera, sim.camera, s.mount, config, where, mistakes);
  }
  CheckImage(s.image, has_camera ? &sim.camera : nullptr, WhereOf(config, "image", where), mistakes);
  CheckInstruments(s.instruments, WhereOf(config, "instruments", where), mistakes);
  sim.cameras = LoadCameras(s.cameras, s.image, beside, config, mistakes);
  if (const auto sight = LoadGroundSight(s.flight.type(), s.ground_camera, beside,
                                         WhereOf(config, "ground_camera", where), mistakes)) {
    sim.ground = sim::GroundCameraParameters{
        .camera = sight->camera, .place = sight->place, .lights = sight->lights, .view = s.ground_view};
    CheckGround(*sim.ground, s.start, s.pad.yaw_deg, config, where, mistakes);
    CheckImage(s.ground_view.image, &sim.ground->camera, WhereOf(config, "ground_view", where), mistakes);
    if (s.deck)
      mistakes.Add(WhereOf(config, "deck", where), "deck",
                   "given, but the camera on the ground stands beside a pad at rest", "valid: null");
  }
  if (s.pad.name == "none") {
    if (s.occlusion.share > 0)
      mistakes.Add(WhereOf(config, "occlusion", where), "occlusion.share",
                   fmt::format("{}, but there is no pad to be covered", s.occlusion.share), "valid: 0");
    CheckHasPad(s.flight, config, where, mistakes);
  } else if (const auto file_of_pad =
                 ModelFile(Model::kPad, s.pad.name, beside, WhereOf(config, "pad", where), mistakes)) {
    const vision::PadFile pad = vision::LoadPad(*file_of_pad, mistakes);
    sim.scene.pad = pad.parameters;
    sim.scene.pad_texture = pad.texture;
    sim.scene.pad_picture = pad.picture;
    if (s.pad.print && !pad.reference.levels.empty())
      sim.scene.pad_picture = sim::Printed(pad.picture, pad.parameters.size_m, *s.pad.print, s.seed);
    loaded.pad = pad.reference;
    std::optional<double> start_m;
    if (!s.start.on_ground && !s.carry) start_m = s.start.height_m;
    if (has_camera)
      CheckPadHeights(s.flight, loaded.pad, sim.camera, s.pilot.tracker, start_m, config, where, mistakes,
                      loaded.pad_heights);
  }
  sim.scene.pad_position_m = s.pad.position_m;
  sim.scene.pad_yaw_deg = s.pad.yaw_deg;
  sim.scene.pad_height_m = s.pad.height_m;
  sim.scene.pad_tilt_deg = s.pad.tilt_deg;
  if (s.pad.uneven_deg > 0) {
    RandomStream random(s.seed, "pad uneven");
    for (double& each : sim.scene.pad_lean_deg) each = s.pad.uneven_deg * random.Normal();
  }
  sim.scene.deck = s.deck;
  sim.sensors = s.sensors;
  sim.instruments = s.instruments;
  sim.actuators = s.actuators;
  sim.mount = s.mount;
  sim.image = s.image;
  sim.camera_error = s.camera_error;
  sim.render = s.render;
  sim.wind = s.wind;
  sim.start = s.start;
  sim.carry = s.carry;
  sim.occlusion = s.occlusion;
  sim.targets = s.targets;
  sim.seed = s.seed;
  sim.duration_s = s.duration_s;
  if (mistakes.empty()) CheckChanges(loaded, s, config, where, mistakes);
  mistakes.ThrowIfAny();
  try {
    if (compile) sim::MakeAirframe(sim.vehicle, sim::MakeModel(sim.scene, false).get(), false);
    CheckLift(sim.vehicle, vehicle_file.string(), mistakes);
  } catch (const std::exception& e) {
    mistakes.Add(where, "", e.what());
  }
  mistakes.ThrowIfAny();
  loaded.notes = NotesOn(s, sim.camera);
  return loaded;
}

}  // namespace

LoadedScenario LoadScenario(const std::string& name_or_file, const std::vector<std::string>& overrides,
                            bool compile) {
  const fs::path file = ScenarioFile(name_or_file);
  LoadedScenario loaded = LoadWithGains(
      file, overrides, [&](const std::vector<std::string>& all) { return LoadWhole(file, all, compile); });
  loaded.again = CommandOf(name_or_file, overrides);
  return loaded;
}

void CheckNumbers(const Scenario& s, const sim::AirframeParameters& aircraft, const Config& config,
                  const Place& where, Mistakes& mistakes) {
  for (const sim::AttitudeFault& fault : s.sensors.attitude_faults) {
    if (fault.until_s <= fault.from_s)
      mistakes.Add(WhereOf(config, "sensors", where), "sensors.attitude_faults",
                   fmt::format("a fault from {} s until {} s", fault.from_s, fault.until_s),
                   "valid: until_s after from_s");
  }
  CheckMission(s.flight, s.image.colour, config, where, mistakes);
  CheckPilot(s.flight, s.pilot, config, where, mistakes);
  sim::CheckFaults(s.sensors, s.actuators, aircraft, WhereOf(config, "sensors", where),
                   WhereOf(config, "actuators", where), mistakes);
  CheckLimits(s.flight,
              {.speed_m_s = s.autopilot.speed_limit_m_s,
               .climb_m_s = s.autopilot.climb_limit_m_s,
               .yaw_rate_deg_s = s.autopilot.yaw_rate_limit_deg_s,
               .acceleration_m_s2 = s.autopilot.acceleration_limit_m_s2},
              config, where, mistakes);
  CheckTargets(s, WhereOf(config, "targets", where), mistakes);
}

mission::MissionParts PartsOf(const LoadedScenario& loaded, const mjModel* model) {
  const sim::SimulatorParameters& sim = loaded.simulator;
  mission::MissionParts parts{.pilot = loaded.scenario.pilot,
                              .camera = sim.camera,
                              .X_BC = vision::MountPose(sim.mount),
                              .pad = loaded.pad,
                              .own_parts = {},
                              .seed = sim.seed};
  if (sim.ground)
    parts.ground = vision::GroundSight{.stream = nullptr,
                                       .camera = sim.ground->camera,
                                       .place = sim.ground->place,
                                       .lights = sim.ground->lights};
  if (!loaded.scenario.flight.type().looks_for_pad)
    parts.own_parts = sim::OwnParts(model, parts.camera, parts.X_BC);
  return parts;
}

}  // namespace kestrel::flight
