// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/file/model_files.h"
#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "sim/camera/pan_tilt.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// What a metric must keep to for the run to pass.
struct Limit {
  std::optional<double> max, min;
};

inline void Fields(FieldVisitor& v, Limit& l) {
  v("max", l.max, -1e9, 1e9);
  v("min", l.min, -1e9, 1e9);
}

// Where the pad lies.
struct PadPlacement {
  std::string name = "helipad";                          // none: there is no pad, only its place
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // north, east
  double yaw_deg = 0;
};

inline void Fields(FieldVisitor& v, PadPlacement& p) {
  v("name", p.name);
  v("position_m", p.position_m, -1e4, 1e4);
  v("yaw_deg", p.yaw_deg, -360.0, 360.0);
}

// A flight as data. Everything that a run depends on is here, in the models it names, or in the program.
struct Scenario {
  std::string name;  // of the run; the file's own when none is given
  std::string mission;
  mission::Flight flight;
  std::uint64_t seed = 1;
  double duration_s = 60;
  std::string vehicle = "pelican", world = "airfield", camera = "thesis_6mm";
  std::string camera_name;                         // which of a file of Kalibr; empty: its first
  sim::AutopilotParameters autopilot;              // as the vehicle has it, but for these
  std::optional<sim::PanTiltParameters> platform;  // likewise; who is served turns the camera with it
  std::optional<sim::LandscapeParameters>
      landscape;  // of a world that is one: as the world has it, but for these
  PadPlacement pad;
  sim::StartParameters start;
  vision::CameraMount mount;
  sim::ImageParameters image;
  sim::RenderOptions render;
  sim::WindParameters wind;
  sim::SensorParameters sensors;
  sim::ActuatorParameters actuators;
  sim::OcclusionParameters occlusion;
  std::vector<sim::TargetParameters> targets;  // what else flies
  mission::PilotParameters pilot;
  std::map<std::string, Limit> criteria;  // by the name of a metric
};

inline void Fields(FieldVisitor& v, Scenario& s) {
  v("name", s.name);
  v(Required("mission"), s.mission, mission::MissionNames());
  mission::SelectMission(s.mission, s.flight);
  v("flight", s.flight);
  v("seed", s.seed);
  v("duration_s", s.duration_s, 0.1, 36000.0);
  v("vehicle", s.vehicle);
  v("world", s.world);
  v("autopilot", s.autopilot);
  v("platform", s.platform);
  v("camera", s.camera);
  v("camera_name", s.camera_name);
  v("landscape", s.landscape);
  v("pad", s.pad);
  v("start", s.start);
  v("mount", s.mount);
  v("image", s.image);
  v("render", s.render);
  v("wind", s.wind);
  v("sensors", s.sensors);
  v("actuators", s.actuators);
  v("occlusion", s.occlusion);
  v("targets", s.targets);
  v("pilot", s.pilot);
  v("criteria", s.criteria);
}

// A scenario with the models that it names, ready to fly.
struct LoadedScenario {
  Scenario scenario;
  sim::SimulatorParameters simulator;
  vision::PadReference pad;
  std::vector<std::string> notes;  // what is valid and may yet surprise, in words
};

// A name in scenarios/, or a YAML file. overrides: "key.path=value". Its key `gains` names a file of such, by
// colons, over its own and under those. Throws InputError with every mistake that they and the models hold.
// compile: also whether world, vehicle and pad go together, which only MuJoCo's compiler can tell, in some 50
// ms; otherwise the Simulator throws it.
LoadedScenario LoadScenario(const std::string& name_or_file, const std::vector<std::string>& overrides = {},
                            bool compile = true);

// model: of the scenario's own scene, as a Simulator has it.
mission::MissionParts PartsOf(const LoadedScenario& loaded, const mjModel* model);

}  // namespace kestrel::flight
