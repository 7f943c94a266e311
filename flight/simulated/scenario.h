// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/file/model_files.h"
#include "base/yaml/fields.h"
#include "flight/change_keys.h"
#include "flight/flight_plan.h"
#include "flight/simulated/equipment.h"
#include "mission/mission_type.h"
#include "sim/camera/pan_tilt.h"
#include "sim/simulator.h"
#include "sim/view/view_parameters.h"
#include "sim/world/print.h"

namespace kestrel::flight {

// What a metric must keep to for the run to pass.
struct Limit {
  std::optional<double> max, min;
};

inline void Fields(FieldVisitor& v, Limit& l) {
  v({"max", "maximum value of the metric with which the run passes"}, l.max, -1e9, 1e9);
  v({"min", "minimum value of the metric with which the run passes"}, l.min, -1e9, 1e9);
}

// Where the pad lies, or hangs.
struct PadPlacement {
  std::string name = "helipad";
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_deg = 0, height_m = 0, tilt_deg = 0, uneven_deg = 0;
  std::optional<sim::PrintParameters> print;
};

inline void Fields(FieldVisitor& v, PadPlacement& p) {
  v({"name", "landing pad: a name in models/pads, or a YAML file; none: there is no pad, only its place"},
    p.name);
  v({"position_m", "position of the middle of the pad's back: north, east"}, p.position_m, -1e4, 1e4);
  v({"yaw_deg", "direction of the top of the pad's picture, clockwise from north"}, p.yaw_deg, -360.0, 360.0);
  v({"height_m", "height of the middle of the pad's back above the ground"}, p.height_m, 0.0, 100.0);
  v({"tilt_deg",
     "how far the top of the pad's picture is raised, from 0, lying, to 90, hanging on a wall that its top "
     "faced"},
    p.tilt_deg, 0.0, 90.0);
  v({"uneven_deg",
     "standard deviation of how far it leans about each of its sides, as on grass, drawn by the seed"},
    p.uneven_deg, 0.0, 15.0);
  v({"print", "how its picture came out in print; the trackers know the picture as it is in the file"},
    p.print);
}

// A flight as data. Everything that a run depends on is here, in the models it names, or in the program.
struct Scenario : FlightKeys {
  std::string vehicle = "pelican", world = "airfield";
  sim::AutopilotParameters autopilot;
  std::optional<sim::PanTiltParameters> platform;
  sim::GroundViewParameters ground_view;
  std::optional<sim::LandscapeParameters> landscape;
  std::vector<sim::MeshParameters> meshes;
  std::optional<sim::GroundPhotoParameters> ground_photo;
  PadPlacement pad;
  std::optional<sim::DeckParameters> deck;
  sim::StartParameters start;
  std::optional<sim::CarryParameters> carry;
  sim::ImageParameters image;
  sim::CameraErrorParameters camera_error;
  sim::EventCameraParameters event_camera;
  sim::RenderOptions render;
  sim::ViewParameters view;
  sim::WindParameters wind;
  sim::SensorParameters sensors;
  sim::InstrumentParameters instruments;
  std::vector<CameraKeys> cameras;
  sim::ActuatorParameters actuators;
  sim::OcclusionParameters occlusion;
  std::vector<sim::TargetParameters> targets;
  std::map<std::string, Limit> criteria;
  std::vector<ChangeableKeys> changeable;
  std::vector<ChangeKeys> changes;
};

inline void Fields(FieldVisitor& v, Scenario& s) {
  Fields(v, static_cast<FlightKeys&>(s));
  v({"vehicle", "aircraft that flies: a name in models/vehicles, or a file"}, s.vehicle);
  v({"world", "world that is flown in: a name in models/worlds, or a file"}, s.world);
  v({"autopilot", "emulated autopilot; what is not given is the vehicle's"}, s.autopilot);
  v({"platform",
     "pan-tilt platform of the camera, which clients of kestrel serve turn; what is not given is the "
     "vehicle's"},
    s.platform);
  v({"ground_view", "what the camera on the ground is like beyond what the flight knows of it"},
    s.ground_view);
  v({"landscape", "terrain and sky of a world that is a landscape; what is not given is the world's"},
    s.landscape);
  v({"meshes", "things from files that stand in the world, beside those that it has"}, s.meshes);
  v({"ground_photo", "photo or orthophoto that lies on the ground; null: the world's"}, s.ground_photo);
  v({"pad", "landing pad and where it lies"}, s.pad);
  v({"deck", "deck that moves, on which the pad lies; null: the pad is at rest"}, s.deck);
  v({"start", "where and how the flight begins"}, s.start);
  v({"carry", "the aircraft is carried along a way by hand, with its motors off; null: it flies"}, s.carry);
  v({"image", "image sensor and lens: frame rate, latency, exposure, noise, faults"}, s.image);
  v({"camera_error", "how far the camera truly is from its calibration, mount and clock, drawn by the seed"},
    s.camera_error);
  v({"event_camera", "event camera behind the same lens, which --events records"}, s.event_camera);
  v({"render", "how the images are rendered"}, s.render);
  v({"view", "camera that watches the flight from outside, for run --view and picture"}, s.view);
  v({"wind", "mean wind, turbulence and gusts"}, s.wind);
  v({"sensors", "errors and faults of the aircraft's sensors"}, s.sensors);
  v({"instruments", "instruments that the aircraft carries beside the sensors of its autopilot"},
    s.instruments);
  v({"cameras", "cameras that the aircraft carries beside the one that it is flown by"}, s.cameras);
  v({"actuators", "faults of rotors and servos"}, s.actuators);
  v({"occlusion", "dark sheet that covers part of the pad for some time"}, s.occlusion);
  v({"targets", "what else flies: balloons or other aircraft, as coloured spheres"}, s.targets);
  v({"criteria", "limits by the names of metrics, which the run must keep to in order to pass"}, s.criteria);
  v({"changeable", "keys that may be changed in flight, by hand or by changes"}, s.changeable);
  v({"changes", "what is changed in flight, and when"}, s.changes);
}

// A scenario with the models that it names, ready to fly.
struct LoadedScenario {
  Scenario scenario;
  sim::SimulatorParameters simulator;
  vision::PadReference pad;
  std::string description;         // the file's sentence of itself; may be empty
  std::string again;               // the command that flies it again
  std::string pad_heights;         // at which the camera can see it, in words; empty: it is not looked for
  std::vector<std::string> notes;  // what is valid and may yet surprise, in words
};

// A name in scenarios/, or a YAML file. overrides: "key.path=value". Its key `gains` names a file of such, by
// colons, over its own and under those. Throws InputError with every mistake that they and the models hold.
// compile: also whether world, vehicle and pad go together, which only MuJoCo's compiler can tell, in some 50
// ms; otherwise the Simulator throws it.
LoadedScenario LoadScenario(const std::string& name_or_file, const std::vector<std::string>& overrides = {},
                            bool compile = true);

// What the numbers of a scenario do not allow together, as far as no file that it names decides. where: what
// has no place in the config.
void CheckNumbers(const Scenario& scenario, const sim::AirframeParameters& aircraft, const Config& config,
                  const Place& where, Mistakes& mistakes);

// model: of the scenario's own scene, as a Simulator has it. A camera on the ground has no stream yet.
mission::MissionParts PartsOf(const LoadedScenario& loaded, const mjModel* model);

}  // namespace kestrel::flight
