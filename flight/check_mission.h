// SPDX-License-Identifier: Apache-2.0
#pragma once

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
void CheckView(const mission::Flight& flight, const std::string& camera_name,
               const vision::CameraModel& camera, const vision::CameraMount& mount, const Config& config,
               const Place& where, Mistakes& mistakes);
// Of a file that has no pad.
void CheckHasPad(const mission::Flight& flight, const Config& config, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
