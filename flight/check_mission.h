// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/yaml/config.h"
#include "mission/mission_type.h"

namespace kestrel::flight {

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
// Of a file that has no pad.
void CheckHasPad(const mission::Flight& flight, const Config& config, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
