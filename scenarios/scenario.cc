// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "geometry/tait_bryan.h"
#include "scenarios/check_image.h"
#include "scenarios/metrics.h"
#include "sim/horizon.h"
#include "vision/calibration_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

// A vehicle's file: the airframe, and how its autopilot is tuned.
struct VehicleFile {
  std::string kind = "multirotor";
  AirframeParameters airframe;
  AutopilotParameters autopilot;
};

template <class Visitor>
void Fields(Visitor& v, VehicleFile& f) {
  v("kind", f.kind, {"multirotor", "helicopter"});
  if (f.kind == "helicopter" && !std::holds_alternative<HelicopterParameters>(f.airframe))
    f.airframe = HelicopterParameters{};
  std::visit([&](auto& airframe) { Fields(v, airframe); }, f.airframe);
  v("autopilot", f.autopilot);
}

template <class... Each>
std::vector<std::string> NamesOf(const std::variant<Each...>&) {
  return {Each::kName...};
}

template <std::size_t index = 0>
void Select(const std::string& mission, Flight& flight) {
  if constexpr (index < std::variant_size_v<Flight>) {
    if (std::variant_alternative_t<index, Flight>::kName != mission)
      return Select<index + 1>(mission, flight);
    if (flight.index() != index) flight.emplace<index>();
  }
}

// Folders, or files of an ending, in a folder.
std::vector<std::string> NamesIn(const fs::path& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (ending.empty() ? entry.is_directory() : entry.path().extension() == ending) {
      names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Whether a model of that name exists; otherwise says which there are.
bool Known(const std::string& what, const std::string& name, const std::vector<std::string>& names,
           const std::string& where, Mistakes& mistakes) {
  if (std::find(names.begin(), names.end(), name) != names.end()) return true;
  const auto near = NearestName(name, names);
  mistakes.Add(where, what,
               fmt::format("there is no {} '{}'; {}", what, name,
                           near ? fmt::format("did you mean '{}'?", *near)
                                : fmt::format("valid: {}", fmt::join(names, ", "))));
  return false;
}

const ConfigNode* Find(const Config& config, std::string_view key) {
  for (const auto& [name, node] : config.root.members) {
    if (name == key) return &node;
  }
  return nullptr;
}

// Where a key of the file was written; the file alone where it was not.
std::string WhereOf(const Config& config, std::string_view key, const std::string& file) {
  const ConfigNode* node = Find(config, key);
  return node ? node->where : file;
}

// The file of a world that is a landscape, if it is one.
std::optional<fs::path> LandscapeFile(const std::string& world) {
  const fs::path file = Root() / "models" / "worlds" / world / (world + ".yaml");
  return fs::is_regular_file(file) ? std::optional(file) : std::nullopt;
}

// A landscape as its world has it, before the scenario's own words.
std::optional<LandscapeParameters> LandscapeOf(const std::string& world, Mistakes& mistakes) {
  const auto file = LandscapeFile(world);
  if (!file) return std::nullopt;
  LandscapeParameters landscape;
  Read(LoadConfig(*file, {}, mistakes), landscape, mistakes);
  return landscape;
}

// Whether a flight looks for the pad: all do that do not say otherwise, by a constant kPadless.
template <class Each>
constexpr bool kLooksForPad = [] {
  if constexpr (requires { Each::kPadless; }) return !Each::kPadless;
  return true;
}();
bool NeedsPad(const Flight& flight) {
  return std::visit([]<class Each>(const Each&) { return kLooksForPad<Each>; }, flight);
}

// Whether a flight tells its target by colour: by a constant kLooksForColour.
bool NeedsColour(const Flight& flight) {
  return std::visit(
      []<class Each>(const Each&) {
        if constexpr (requires { Each::kLooksForColour; }) return Each::kLooksForColour;
        return false;
      },
      flight);
}

// What of a scenario and a landscape does not go together.
void CheckLandscape(const Scenario& s, const Config& config, const std::string& where, Mistakes& mistakes) {
  if (LandscapeFile(s.world)) {
    if (s.render.backend != "auto" && s.render.backend != "ray") {
      mistakes.Add(WhereOf(config, "render", where), "render.backend",
                   fmt::format("'{}' draws to 500 m alone, and the world '{}' reaches beyond its horizon; "
                               "valid: ray",
                               s.render.backend, s.world));
    }
  } else if (s.landscape) {
    std::vector<std::string> landscapes;
    for (const std::string& name : NamesIn(Root() / "models" / "worlds", ""))
      if (LandscapeFile(name)) landscapes.push_back(name);
    mistakes.Add(WhereOf(config, "landscape", where), "landscape",
                 fmt::format("the world '{}' is not made from numbers; worlds that are: {}", s.world,
                             fmt::join(landscapes, ", ")));
  }
}

struct NoMoreThan {
  const std::string& where;
  Mistakes& mistakes;
  void operator()(const std::string& key, double value, double limit, const std::string& limit_key) const {
    if (value > limit)
      mistakes.Add(where, key,
                   fmt::format("{:g}, and {} is {:g}; valid: no more than that", value, limit_key, limit));
  }
};

void CheckColour(const ColourRange& colour, const std::string& key, const std::string& where,
                 Mistakes& mistakes) {
  if (colour.least_value >= colour.most_value)
    mistakes.Add(where, key + ".least_value",
                 fmt::format("{:g} is not below most_value = {:g}: no pixel can match", colour.least_value,
                             colour.most_value));
}

// No more of the aircraft than its autopilot gives.
void CheckAvoid(const AvoidFlight& flight, const AutopilotParameters& autopilot, const std::string& where,
                Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.speed_m_s", flight.speed_m_s, autopilot.speed_limit_m_s, "autopilot.speed_limit_m_s");
  most("flight.avoidance.hold.yaw_rate_limit_deg_s", flight.avoidance.hold.yaw_rate_limit_deg_s,
       autopilot.yaw_rate_limit_deg_s, "autopilot.yaw_rate_limit_deg_s");
  most("flight.avoidance.acceleration_m_s2", flight.avoidance.acceleration_m_s2,
       autopilot.acceleration_limit_m_s2, "autopilot.acceleration_limit_m_s2");
  most("flight.avoidance.hold.bearing_deg", flight.avoidance.hold.bearing_deg,
       flight.avoidance.most_bearing_deg, "flight.avoidance.most_bearing_deg");
  if (flight.marks.empty() && !flight.contrast)
    mistakes.Add(where, "flight.marks", "is empty; valid: at least one, or a flight.contrast");
  for (std::size_t i = 0; i < flight.marks.size(); ++i) {
    const ColourRange& a = flight.marks[i].colour;
    CheckColour(a, fmt::format("flight.marks.{}.colour", i), where, mistakes);
    for (std::size_t j = 0; j < i; ++j) {
      const ColourRange& b = flight.marks[j].colour;
      const double apart_deg = std::abs(Degrees(WrapAngle(Radians(a.hue_deg - b.hue_deg))));
      if (apart_deg < a.hue_half_width_deg + b.hue_half_width_deg)
        mistakes.Add(where, fmt::format("flight.marks.{}.colour", i),
                     fmt::format("hues {:g} +- {:g} overlap those of mark {}, {:g} +- {:g}: two marks alike "
                                 "cannot be told apart; valid: hues of their own",
                                 a.hue_deg, a.hue_half_width_deg, j, b.hue_deg, b.hue_half_width_deg));
    }
  }
  if (!flight.contrast) return;
  const ContrastTrackerOptions& tracker = flight.contrast->tracker;
  most("flight.contrast.tracker.confirm_sightings", tracker.confirm_sightings, tracker.confirm_images,
       "flight.contrast.tracker.confirm_images");
  most("flight.contrast.tracker.detector.least_diameter_px", tracker.detector.least_diameter_px,
       tracker.detector.most_diameter_px, "flight.contrast.tracker.detector.most_diameter_px");
}

void CheckFollow(const FollowFlight& flight, const AutopilotParameters& autopilot, const std::string& where,
                 Mistakes& mistakes) {
  if (flight.reference.empty()) mistakes.Add(where, "flight.reference", "is empty; valid: at least one");
  CheckColour(flight.balloon.colour, "flight.balloon.colour", where, mistakes);
  const NoMoreThan most{where, mistakes};
  most("flight.gains.speed_limit_m_s", flight.gains.speed_limit_m_s, autopilot.speed_limit_m_s,
       "autopilot.speed_limit_m_s");
  most("flight.gains.climb_limit_m_s", flight.gains.climb_limit_m_s, autopilot.climb_limit_m_s,
       "autopilot.climb_limit_m_s");
  most("flight.gains.yaw_rate_limit_deg_s", flight.gains.yaw_rate_limit_deg_s, autopilot.yaw_rate_limit_deg_s,
       "autopilot.yaw_rate_limit_deg_s");
}

// Who is to be avoided comes from ahead.
void CheckLooksAhead(const CameraModel& camera, const CameraMount& mount, const std::string& where,
                     Mistakes& mistakes) {
  const auto at = Project(camera, MountPose(mount).R.conjugate() * Eigen::Vector3d::UnitX());
  if (!at || at->x() < 0 || at->y() < 0 || at->x() > WidthPx(camera) - 1 || at->y() > HeightPx(camera) - 1)
    mistakes.Add(
        where, "mount.pitch_deg",
        fmt::format("{:g}: the camera does not see straight ahead, where others come from; valid: one "
                    "that does (90 looks ahead)",
                    mount.pitch_deg));
}

// A balloon can be wanted only where the camera sees it, at least from a level aircraft.
void CheckReferences(const FollowFlight& flight, const CameraModel& camera, const CameraMount& mount,
                     const std::string& where, Mistakes& mistakes) {
  constexpr int kPoints = 72;  // of the circle
  const double focal_px = Parameters(camera)[0];
  const Eigen::Quaterniond R_CB = MountPose(mount).R.conjugate();
  const auto seen = [&](const FollowReference& r, double angle) {
    const double radius_px = r.diameter_px / 2;
    const Eigen::Vector3d ahead(focal_px, r.u_px + radius_px * std::cos(angle),
                                r.v_px + radius_px * std::sin(angle));
    const auto at = Project(camera, R_CB * ahead);
    return at && at->x() >= 0 && at->y() >= 0 && at->x() <= WidthPx(camera) - 1 &&
           at->y() <= HeightPx(camera) - 1;
  };
  for (std::size_t i = 0; i < flight.reference.size(); ++i) {
    const FollowReference& r = flight.reference[i];
    const std::string key = fmt::format("flight.reference.{}", i);
    if (i > 0 && r.from_s <= flight.reference[i - 1].from_s)
      mistakes.Add(where, key + ".from_s",
                   fmt::format("{:g} is not after the one before; valid: above {:g}", r.from_s,
                               flight.reference[i - 1].from_s));
    bool whole = true;
    for (int k = 0; k < kPoints && whole; ++k) whole = seen(r, 2 * M_PI * k / kPoints);
    if (!whole)
      mistakes.Add(where, key,
                   fmt::format("u_px {:g}, v_px {:g} and diameter_px {:g} are a circle beyond the image of "
                               "{} x {} px, by this camera as it is mounted; valid: one within it, nearer "
                               "to the middle or smaller, and a camera that looks ahead",
                               r.u_px, r.v_px, r.diameter_px, WidthPx(camera), HeightPx(camera)));
  }
}

void CheckTargets(const Scenario& s, const std::string& where, Mistakes& mistakes) {
  for (std::size_t i = 0; i < s.targets.size(); ++i) {
    const TargetParameters& t = s.targets[i];
    const std::string name = fmt::format("targets[{}]", i);
    if ((t.velocity_m_s.norm() > 0) + (t.string_m > 0) + (t.roam_m_s > 0) > 1)
      mistakes.Add(where, name, "moves in several ways; valid: one of velocity_m_s, string_m and roam_m_s");
    const double lowest_m = t.position_m.z() - t.diameter_m / 2 - t.string_m;
    if (lowest_m < 0)
      mistakes.Add(where, name + ".position_m",
                   fmt::format("with its diameter and string it reaches {:.3g} m into the ground; valid: a "
                               "height from {:.3g} m",
                               -lowest_m, t.position_m.z() - lowest_m));
  }
}

// Whether an aircraft can carry its own weight.
void CheckLift(const AirframeParameters& vehicle, const std::string& where, Mistakes& mistakes) {
  const double mass = Mass_kg(vehicle), weight = mass * 9.80665, thrust = GreatestThrust_n(vehicle);
  if (thrust < 1.2 * weight) {
    mistakes.Add(
        where, "mass_kg",
        fmt::format(
            "{} weighs {:.3g} N, and the rotors give {:.3g} N at most; valid: a fifth more than the weight",
            mass, weight, thrust));
  }
  const auto* helicopter = std::get_if<HelicopterParameters>(&vehicle);
  if (helicopter && HoverPower_w(*helicopter) > 0.9 * helicopter->drive.power_w) {
    mistakes.Add(where, "drive.power_w",
                 fmt::format("{:g} W, and hovering takes {:.0f} W; valid: a ninth more than that",
                             helicopter->drive.power_w, HoverPower_w(*helicopter)));
  }
}

std::vector<std::string> NotesOn(const Scenario& s, const CameraModel& camera) {
  std::vector<std::string> notes;
  if (const double covered = ShareCovered(camera); covered < 1) {
    notes.push_back(fmt::format(
        "the camera '{}' fills {:.0f} % of its image, to {:.4g} deg from its axis; the rest is black",
        s.camera, 100 * covered, Degrees(MaxAngle(camera))));
  }
  Mistakes none;
  const auto file = s.camera.find('/') == std::string::npos ? std::nullopt : std::optional(s.camera);
  const auto names = file ? CameraNames(LoadConfig(*file, {}, none)) : std::vector<std::string>();
  if (names.size() > 1) {
    notes.push_back(fmt::format("the camera is {} of '{}', which has {}",
                                s.camera_name.empty() ? names.front() : s.camera_name, s.camera,
                                fmt::join(names, ", ")));
  }
  return notes;
}

}  // namespace

std::vector<std::string> MissionNames() { return NamesOf(Flight{}); }
void SelectFlight(const std::string& mission, Flight& flight) { Select(mission, flight); }

fs::path Root() {
  const char* root = std::getenv("KESTREL_ROOT");
  return root && *root ? fs::path(root) : fs::path(KESTREL_SOURCE_DIR);
}

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const std::string& folder : NamesIn(Root() / "scenarios", "")) {
    for (const std::string& name : NamesIn(Root() / "scenarios" / folder, ".yaml")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<fs::path> CameraFile(std::string& name, const fs::path& beside, const std::string& where,
                                   Mistakes& mistakes) {
  const fs::path folder = Root() / "models" / "cameras";
  const std::vector<std::string> names = NamesIn(folder, ".yaml");
  if (std::find(names.begin(), names.end(), name) != names.end()) return folder / (name + ".yaml");
  for (const fs::path& candidate : {beside / name, fs::path(name)}) {
    if (!fs::is_regular_file(candidate)) continue;
    name = fs::absolute(candidate).lexically_normal().string();
    return name;
  }
  const std::string key = where == "--camera" ? "" : "camera";
  if (name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml")) {
    mistakes.Add(where, key, fmt::format("there is no file '{}'", name));
  } else {
    const auto near = NearestName(name, names);
    mistakes.Add(where, key,
                 fmt::format("there is no camera '{}'; {}", name,
                             near ? fmt::format("did you mean '{}'?", *near)
                                  : fmt::format("valid: {}", fmt::join(names, ", "))));
  }
  return std::nullopt;
}

LoadedScenario LoadScenario(const std::string& name_or_file, const std::vector<std::string>& overrides) {
  Mistakes mistakes;
  fs::path file = name_or_file;
  if (!fs::exists(Root() / "scenarios")) {
    throw InputError({fmt::format("KESTREL_ROOT: '{}' holds no scenarios", Root().string())});
  }
  if (file.extension() != ".yaml" && file.extension() != ".yml" && !fs::is_regular_file(file)) {
    file.clear();
    for (const std::string& folder : NamesIn(Root() / "scenarios", "")) {
      const fs::path candidate = Root() / "scenarios" / folder / (name_or_file + ".yaml");
      if (fs::exists(candidate)) file = candidate;
    }
    if (file.empty()) {
      Known("scenario", name_or_file, ScenarioNames(), "kestrel", mistakes);
      mistakes.ThrowIfAny();
    }
  }

  LoadedScenario loaded;
  Scenario& s = loaded.scenario;
  const Config config = LoadConfig(file, overrides, mistakes);
  if (const ConfigNode* world = Find(config, "world")) s.landscape = LandscapeOf(world->text, mistakes);
  const auto landscape = s.landscape;
  const ConfigNode* named = Find(config, "vehicle");
  const fs::path vehicle_folder = Root() / "models" / "vehicles" / (named ? named->text : s.vehicle);
  const fs::path vehicle_file = vehicle_folder / (vehicle_folder.filename().string() + ".yaml");
  VehicleFile vehicle;
  if (fs::is_regular_file(vehicle_file)) Read(LoadConfig(vehicle_file, {}, mistakes), vehicle, mistakes);
  s.autopilot = vehicle.autopilot;
  Read(config, s, mistakes);
  if (!s.landscape) s.landscape = landscape;  // it was given without a word
  if (!config.readable) mistakes.ThrowIfAny();
  if (s.name.empty()) s.name = file.stem().string();
  const std::string where = file.string();
  if (s.name.find_first_of("/\\") != std::string::npos || s.name.starts_with('.')) {
    mistakes.Add(WhereOf(config, "name", where), "name",
                 fmt::format("'{}' cannot name a folder; valid: no slash, no leading dot", s.name));
  }
  if (std::holds_alternative<LandingFlight>(s.flight) && s.start.on_ground) {
    mistakes.Add(WhereOf(config, "start", where), "start.on_ground",
                 "true, but a landing begins in the air; valid: false");
  }
  if (s.occlusion.until_s <= s.occlusion.from_s) {
    mistakes.Add(WhereOf(config, "occlusion", where), "occlusion.until_s",
                 fmt::format("{} is not after from_s = {}", s.occlusion.until_s, s.occlusion.from_s));
  }
  for (const AttitudeFault& fault : s.sensors.attitude_faults) {
    if (fault.until_s <= fault.from_s)
      mistakes.Add(WhereOf(config, "sensors", where), "sensors.attitude_faults",
                   fmt::format("a fault from {} s until {} s; valid: until_s after from_s", fault.from_s,
                               fault.until_s));
  }
  CheckFaults(s.sensors, s.actuators, vehicle.airframe, WhereOf(config, "sensors", where),
              WhereOf(config, "actuators", where), mistakes);
  if (NeedsColour(s.flight) && !s.image.colour)
    mistakes.Add(
        WhereOf(config, "image", where), "image.colour",
        fmt::format("false, but the mission '{}' tells its target by colour; valid: true", s.mission));
  if (const auto* avoid = std::get_if<AvoidFlight>(&s.flight)) {
    CheckAvoid(*avoid, s.autopilot, WhereOf(config, "flight", where), mistakes);
  }
  if (const auto* follow = std::get_if<FollowFlight>(&s.flight))
    CheckFollow(*follow, s.autopilot, WhereOf(config, "flight", where), mistakes);
  CheckTargets(s, WhereOf(config, "targets", where), mistakes);
  CheckLandscape(s, config, where, mistakes);
  CheckMount(s.mount, WhereOf(config, "mount", where), mistakes);
  const std::string criteria = WhereOf(config, "criteria", where);
  for (const auto& [metric, limit] : s.criteria) {
    Known("criteria", metric, MetricNames(), criteria, mistakes);
    if (!limit.max && !limit.min)
      mistakes.Add(where, "criteria." + metric, "has no limit; valid: max, min or both");
  }

  SimulatorParameters& sim = loaded.simulator;
  const fs::path models = Root() / "models";
  Known("vehicle", s.vehicle, NamesIn(models / "vehicles", ""), WhereOf(config, "vehicle", where), mistakes);
  sim.scene.vehicle = vehicle_folder / (s.vehicle + ".xml");
  sim.vehicle = vehicle.airframe;
  sim.autopilot = s.autopilot;
  if (Known("world", s.world, NamesIn(models / "worlds", ""), WhereOf(config, "world", where), mistakes)) {
    const fs::path folder = models / "worlds" / s.world;
    sim.scene.world = folder / (s.world + (s.landscape ? ".yaml" : ".xml"));
    sim.scene.landscape = s.landscape;
    sim.scene.seed = s.seed;
  }
  bool has_camera = false;
  if (const auto camera =
          CameraFile(s.camera, file.parent_path(), WhereOf(config, "camera", where), mistakes)) {
    const std::size_t before = mistakes.messages().size();
    sim.camera = LoadCamera(*camera, mistakes, s.camera_name);
    has_camera = mistakes.messages().size() == before;
    if (has_camera && NeedsPad(s.flight) && !TrackersCamera(sim.camera)) {
      const Eigen::VectorXd numbers = Parameters(sim.camera);
      mistakes.Add(
          WhereOf(config, "camera", where), "camera",
          fmt::format("'{}' does not see along its own optical axis, where these flights look for "
                      "the pad: its principal point ({:g}, {:g}) is too near to the edge of the image "
                      "of {} x {} px or beyond it; valid: a camera that has it well within",
                      s.camera, numbers[2], numbers[3], WidthPx(sim.camera), HeightPx(sim.camera)));
    }
  }
  if (std::holds_alternative<AvoidFlight>(s.flight) && has_camera)
    CheckLooksAhead(sim.camera, s.mount, WhereOf(config, "mount", where), mistakes);
  if (const auto* follow = std::get_if<FollowFlight>(&s.flight); follow && has_camera)
    CheckReferences(*follow, sim.camera, s.mount, WhereOf(config, "flight", where), mistakes);
  CheckImage(s.image, has_camera ? &sim.camera : nullptr, WhereOf(config, "image", where), mistakes);
  if (s.pad.name == "none") {
    if (s.occlusion.share > 0)
      mistakes.Add(WhereOf(config, "occlusion", where), "occlusion.share",
                   fmt::format("{}, but there is no pad to be covered; valid: 0", s.occlusion.share));
    if (NeedsPad(s.flight))
      mistakes.Add(WhereOf(config, "pad", where), "pad.name",
                   fmt::format("none, but the mission '{}' looks for a pad; valid: {}", s.mission,
                               fmt::join(NamesIn(models / "pads", ""), ", ")));
  } else if (Known("pad", s.pad.name, NamesIn(models / "pads", ""), WhereOf(config, "pad", where),
                   mistakes)) {
    const fs::path folder = models / "pads" / s.pad.name;
    Read(LoadConfig(folder / (s.pad.name + ".yaml"), {}, mistakes), sim.scene.pad, mistakes);
    sim.scene.pad_texture = folder / sim.scene.pad.texture;
    const cv::Mat picture = cv::imread(sim.scene.pad_texture.string(), cv::IMREAD_GRAYSCALE);
    if (picture.empty()) {
      mistakes.Add((folder / (s.pad.name + ".yaml")).string(), "texture",
                   fmt::format("{} cannot be read as an image", sim.scene.pad_texture.string()));
    } else if (!std::has_single_bit(static_cast<unsigned>(picture.cols)) ||
               !std::has_single_bit(static_cast<unsigned>(picture.rows))) {
      mistakes.Add(
          (folder / (s.pad.name + ".yaml")).string(), "texture",
          fmt::format(
              "{} has {} x {} pixels; the sides must be powers of two (2048 x 2048), or OpenGL draws the "
              "pad askew from far away",
              sim.scene.pad_texture.string(), picture.cols, picture.rows));
    } else {
      loaded.pad = MakePadReference(picture, sim.scene.pad.size_m.x(), sim.scene.pad.size_m.y());
    }
  }
  sim.scene.pad_position_m = s.pad.position_m;
  sim.scene.pad_yaw_deg = s.pad.yaw_deg;
  sim.sensors = s.sensors;
  sim.actuators = s.actuators;
  sim.mount = s.mount;
  sim.image = s.image;
  sim.render = s.render;
  sim.wind = s.wind;
  sim.start = s.start;
  sim.occlusion = s.occlusion;
  sim.targets = s.targets;
  sim.seed = s.seed;
  sim.duration_s = s.duration_s;
  mistakes.ThrowIfAny();
  try {
    const ModelPtr model = MakeModel(
        sim.scene, false);  // world, vehicle and pad together: what only the compiler of MuJoCo can refuse
    MakeAirframe(sim.vehicle, model.get(), false);
    CheckLift(sim.vehicle, vehicle_file.string(), mistakes);
  } catch (const std::exception& e) {
    mistakes.Add(where, "", e.what());
  }
  mistakes.ThrowIfAny();
  loaded.notes = NotesOn(s, sim.camera);
  return loaded;
}

std::unique_ptr<Mission> MakeMission(const LoadedScenario& loaded) {
  const SimulatorParameters& sim = loaded.simulator;
  const Pose X_BC = MountPose(sim.mount);
  return std::visit(
      [&]<class Each>(const Each& flight) {
        if constexpr (kLooksForPad<Each>) {
          return MakeMission(flight, HelipadPilot(loaded.pad, sim.camera, X_BC, loaded.scenario.pilot));
        } else {
          const ModelPtr model = MakeModel(sim.scene, false);
          return MakeMission(flight, sim.camera, X_BC, OwnParts(model.get(), sim.camera, X_BC), sim.seed);
        }
      },
      loaded.scenario.flight);
}

}  // namespace kestrel
