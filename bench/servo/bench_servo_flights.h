// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

namespace kestrel::bench {

// The scenario `servo` by each of its laws: hovers in wind, by the level camera and without it; and the tasks of
// Gans, Corke and Hutchinson (bench/servo/servo_tasks.h) flown, with the aircraft's dynamics, wind and latency, of
// which a table of its own is printed.
void BenchServoFlights(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// The scenarios `hover_direct` and `hover_photometric`. Over which rates and latencies they hold, the campaign
// `margin` tells.
void BenchDirect(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
