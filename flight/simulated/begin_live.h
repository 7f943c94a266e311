// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "flight/live/live.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/flight_records.h"
#include "flight/simulated/scenario.h"
#include "mission/mission.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// From now on viewers see this flight, and change what its scenario lets change. simulator: at its begin; scene_glb: of it; parts: what
// flies it is made from; changes: of this flight; records: its own, null: it has none; both must outlive it. pace_refused: why its time is not theirs; empty: it
// is.
void BeginLive(Live& live, const LoadedScenario& loaded, const sim::Simulator& simulator,
               const std::string& scene_glb, const mission::MissionParts& parts, Changes& changes,
               const FlightRecords* records, const std::string& pace_refused = {});

}  // namespace kestrel::flight
