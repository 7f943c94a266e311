// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/diagnostics.h"
#include "flight/dataset/trajectory/way_file.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// Where a trajectory leaves the world or goes into the ground, and what of a scenario frames that are drawn
// each by itself cannot have.
void CheckTrajectory(const LoadedTrajectory& loaded, const sim::SimulatorParameters& simulator,
                     Mistakes& mistakes);

}  // namespace kestrel::flight
