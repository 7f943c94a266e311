// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "scenarios/avoid/avoid.h"

namespace kestrel::scenarios {

// Thesis 6.4 to the letter: ahead at a constant speed, and as soon as CamShift has the mark the yaw rate holds
// its bearing, (6.24), at +-50 degrees by (6.29). No range, no filter and no end but by hand.
std::unique_ptr<mission::Mission> MakeSightMission(const AvoidFlight& flight,
                                                   const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
