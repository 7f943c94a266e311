// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"
#include "flight/ground_keys.h"
#include "mission/mission_type.h"

namespace kestrel::flight {

// The keys that every flight has, in the simulator or on a real aircraft.
struct FlightKeys {
  std::string name;     // of the run and of its folder; empty: that of the file
  std::string mission;  // which mission is flown
  mission::Flight flight;
  std::uint64_t seed = 1;
  double duration_s = 60;
  std::string camera = "thesis_6mm", camera_name;
  vision::CameraMount mount;
  std::optional<GroundCameraKeys> ground_camera;
  mission::PilotParameters pilot;
};

inline void Fields(FieldVisitor& v, FlightKeys& k) {
  v({"name", "name of the run and of its folder; empty: that of the file"}, k.name);
  v(Required("mission", "which mission is flown"), k.mission, mission::MissionNames());
  mission::SelectMission(k.mission, k.flight);
  v({"flight", "parameters of the mission"}, k.flight);
  v({"seed", "seed of all random numbers of the flight"}, k.seed);
  v({"duration_s", "longest time of the flight; the mission may end it earlier"}, k.duration_s, 0.1, 36000.0);
  v({"camera", "camera: a name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV"},
    k.camera);
  v({"camera_name", "which camera of a file of Kalibr; empty: its first"}, k.camera_name);
  v({"mount", "position and orientation of the camera on the aircraft"}, k.mount);
  v({"ground_camera", "camera on the ground that sees the aircraft; null: there is none"}, k.ground_camera);
  v({"pilot", "vision, estimation and control of missions over a pad"}, k.pilot);
}

// What a scenario says of the flight itself, whoever's world it is flown in: the part that a real aircraft
// and a recording need. A file of the simulator is read as it is; what it says of its world is passed over.
struct FlightPlan : FlightKeys {
  struct Pad {
    std::string name = "helipad";
  };
  struct Image {
    bool colour = false;
    double rate_hz = 20;
  };
  std::string own_parts;
  Pad pad;
  Image image;
};

inline void Fields(FieldVisitor& v, FlightPlan::Pad& p) {
  v({"name", "landing pad: a name in models/pads, or a YAML file; none: the mission looks for none"}, p.name);
}

inline void Fields(FieldVisitor& v, FlightPlan::Image& i) {
  v({"colour", "colour images; false: grey ones"}, i.colour);
  v({"rate_hz", "frame rate that the camera should keep"}, i.rate_hz, 0.5, 500.0);
}

inline void Fields(FieldVisitor& v, FlightPlan& p) {
  Fields(v, static_cast<FlightKeys&>(p));
  v({"own_parts",
     "picture, white where the camera sees its aircraft; empty: own_parts.png beside this file, if any"},
    p.own_parts);
  v({"pad", "landing pad that the mission looks for"}, p.pad);
  v({"image", "images that the camera is to give"}, p.image);
}

struct LoadedPlan {
  FlightPlan plan;
  mission::MissionParts parts;
  std::string description;  // the file's sentence of itself; may be empty
};

// As LoadScenario. The picture own_parts is looked for beside the file; a file own_parts.png there is taken
// where the key is not given, as a recording has it. Throws InputError with every mistake.
LoadedPlan LoadPlan(const std::string& name_or_file, const std::vector<std::string>& overrides = {});

// The keys of a scenario, dotted where only a part is meant, that say something of the simulated world alone.
const std::vector<std::string_view>& WorldKeys();

}  // namespace kestrel::flight
