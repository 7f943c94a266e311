// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"

namespace kestrel::flight {

// What a scenario says of the flight itself, whoever's world it is flown in: the part that a real aircraft
// and a recording need. A file of the simulator is read as it is; what it says of its world is passed over.
struct FlightPlan {
  struct Pad {
    std::string name = "helipad";  // of models/pads; none: the flight looks for none
  };
  struct Image {
    bool colour = false;
    double rate_hz = 20;  // that the camera should keep
  };
  std::string name;
  std::string mission;
  mission::Flight flight;
  std::uint64_t seed = 1;
  double duration_s = 60;
  std::string camera = "thesis_6mm", camera_name;
  std::string own_parts;  // picture of where the camera sees the aircraft itself: white there; empty: nowhere
  Pad pad;
  vision::CameraMount mount;
  Image image;
  mission::PilotParameters pilot;
};

inline void Fields(FieldVisitor& v, FlightPlan::Pad& p) { v("name", p.name); }

inline void Fields(FieldVisitor& v, FlightPlan::Image& i) {
  v("colour", i.colour);
  v("rate_hz", i.rate_hz, 0.5, 500.0);
}

inline void Fields(FieldVisitor& v, FlightPlan& p) {
  v("name", p.name);
  v(Required("mission"), p.mission, mission::MissionNames());
  mission::SelectMission(p.mission, p.flight);
  v("flight", p.flight);
  v("seed", p.seed);
  v("duration_s", p.duration_s, 0.1, 36000.0);
  v("camera", p.camera);
  v("camera_name", p.camera_name);
  v("own_parts", p.own_parts);
  v("pad", p.pad);
  v("mount", p.mount);
  v("image", p.image);
  v("pilot", p.pilot);
}

struct LoadedPlan {
  FlightPlan plan;
  mission::MissionParts parts;
};

// As LoadScenario. The picture own_parts is looked for beside the file; a file own_parts.png there is taken
// where the key is not given, as a recording has it. Throws InputError with every mistake.
LoadedPlan LoadPlan(const std::string& name_or_file, const std::vector<std::string>& overrides = {});

// The keys of a scenario, dotted where only a part is meant, that say something of the simulated world alone.
const std::vector<std::string_view>& WorldKeys();

}  // namespace kestrel::flight
