// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "control/autopilot.h"
#include "geometry/truth.h"
#include "mission/decision.h"

// The parts of the replies of the lockstep protocol (docs/guide/lockstep.md). Numbers are written in full: who
// reads them by the rules of IEEE 754 has the same bits.
namespace kestrel::flight {

nlohmann::ordered_json LockstepJson(const control::VehicleState& state);
nlohmann::ordered_json LockstepJson(const Truth& truth);
nlohmann::ordered_json LockstepJson(
    const mission::Decision& decision);  // what goes into a step, and its outcome

}  // namespace kestrel::flight
