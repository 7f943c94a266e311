// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "scenarios/hover/hover.h"
#include "scenarios/landing/landing.h"

// Flights of hover and landing by a camera on the ground, eye-to-hand, and by both cameras (thesis 5.2.1).
namespace kestrel::scenarios {

struct HoverGroundFlight : HoverFlight {};
struct LandingGroundFlight : LandingFlight {};
struct LandingHybridFlight : LandingFlight {};

inline void Fields(FieldVisitor& v, HoverGroundFlight& p) { Fields(v, static_cast<HoverFlight&>(p)); }
inline void Fields(FieldVisitor& v, LandingGroundFlight& p) { Fields(v, static_cast<LandingFlight&>(p)); }
inline void Fields(FieldVisitor& v, LandingHybridFlight& p) { Fields(v, static_cast<LandingFlight&>(p)); }

mission::MissionType TypeOf(const HoverGroundFlight& flight);
mission::MissionType TypeOf(const LandingGroundFlight& flight);
mission::MissionType TypeOf(const LandingHybridFlight& flight);

std::unique_ptr<mission::Mission> MakeMission(const HoverGroundFlight& flight,
                                              const mission::MissionParts& parts);
std::unique_ptr<mission::Mission> MakeMission(const LandingGroundFlight& flight,
                                              const mission::MissionParts& parts);
std::unique_ptr<mission::Mission> MakeMission(const LandingHybridFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
