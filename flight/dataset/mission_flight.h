// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flight/dataset/journal.h"
#include "flight/dataset/plan.h"

namespace kestrel::flight {

// Fills a sequence with a flight of its scenario's mission, and writes its pictures on so many threads
// beside the flight. What is written already is flown again and not written again: the same seed flies the
// same flight.
void FlyMission(const DatasetPlan& plan, std::uint64_t seed, int threads, Journal& journal,
                Sequence& sequence);

}  // namespace kestrel::flight
