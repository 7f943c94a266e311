// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "vision/aircraft/aircraft_lights.h"
#include "vision/aircraft/ground_camera.h"

namespace kestrel::flight {

// What a flight knows of a camera on the ground.
struct GroundCameraKeys {
  std::string camera = "ground_6mm", camera_name;
  vision::GroundPlace place;
  vision::AircraftLights lights;
};

inline void Fields(FieldVisitor& v, GroundCameraKeys& k) {
  v({"camera", "camera: a name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV"},
    k.camera);
  v({"camera_name", "which camera of a file of Kalibr; empty: its first"}, k.camera_name);
  v({"place", "where it stands beside the pad, as survey or calibration has it"}, k.place);
  v({"lights", "lights on the aircraft by which it is seen"}, k.lights);
}

// The sight of a mission that flies by a camera on the ground, without its stream. What of it cannot be is a
// mistake: there is none, or one that the mission has no use for; lights that tell no pose. where: of the
// key `ground_camera`, or the file. The camera's name becomes that of its file. None: no use, or a mistake.
std::optional<vision::GroundSight> LoadGroundSight(const mission::MissionType& type,
                                                   std::optional<GroundCameraKeys>& keys,
                                                   const std::filesystem::path& beside, const Place& where,
                                                   Mistakes& mistakes);

}  // namespace kestrel::flight
