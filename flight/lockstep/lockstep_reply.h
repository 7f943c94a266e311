// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "control/autopilot.h"
#include "geometry/truth.h"
#include "mission/decision.h"
#include "sim/instrument/readings.h"

// The parts of the replies of the lockstep protocol (docs/guide/lockstep.md). Numbers are written in full: who
// reads them by the rules of IEEE 754 has the same bits.
namespace kestrel::flight {

nlohmann::ordered_json LockstepJson(const control::VehicleState& state);
nlohmann::ordered_json LockstepJson(const Truth& truth);
nlohmann::ordered_json LockstepJson(const std::vector<sim::TruthSample>& samples);
// Of the instruments that have given something; an empty object: none has.
nlohmann::ordered_json LockstepJson(const sim::Readings& readings);
// What goes into a step, and how the flight is to end.
nlohmann::ordered_json LockstepJson(const mission::Decision& decision);

}  // namespace kestrel::flight
