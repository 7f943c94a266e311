// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flight/dataset/journal.h"
#include "flight/dataset/plan.h"

namespace kestrel::flight {

// Fills a sequence along the plan's trajectory, frames on all jobs, and writes its pictures. simulator: of its
// scenario.
void FlyTrajectory(const DatasetPlan& plan, const sim::SimulatorParameters& simulator, Journal& journal,
                   Sequence& sequence);

}  // namespace kestrel::flight
