// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/yaml/config.h"
#include "mission/mission_type.h"

namespace kestrel::flight {

// Whether there is the mission that a file names. Where there is none, it is the one mistake made of it: what the
// file says of that mission is taken out, since nothing is known that it could be held against.
void CheckMissionExists(Config& config, const Place& where, Mistakes& mistakes);

// What a mission and the rest of the file do not allow together. where: the file, for what it does not say
// itself. All of it is a mistake before anything starts.
void CheckMission(const mission::Flight& flight, bool colour, const Config& config, const Place& where,
                  Mistakes& mistakes);
void CheckLimits(const mission::Flight& flight, const mission::AircraftLimits& limits, const Config& config,
                 const Place& where, Mistakes& mistakes);
void CheckView(const mission::Flight& flight, const std::string& camera_name,
               const vision::CameraModel& camera, const vision::CameraMount& mount, const Config& config,
               const Place& where, Mistakes& mistakes);
// Of a mission that looks for the pad: whether this build can do what its pilot is to do.
void CheckPilot(const mission::Flight& flight, const mission::PilotParameters& pilot, const Config& config,
                const Place& where, Mistakes& mistakes);
// Whether the pad can be seen where the flight begins and as low as it needs it; start_m: none where it begins on
// the ground or nobody knows. heights: the note of what the pad is worth for the camera.
void CheckPadHeights(const mission::Flight& flight, const vision::PadReference& pad,
                     const vision::CameraModel& camera, const vision::PadTrackerOptions& tracker,
                     std::optional<double> start_m, const Config& config, const Place& where,
                     Mistakes& mistakes, std::string& note);
// Of a file that has no pad.
void CheckHasPad(const mission::Flight& flight, const Config& config, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
