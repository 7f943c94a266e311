// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// The helipad by both methods of pilot.tracker.method on the same images: drawn by the scenario "pose" along a
// path that sways and stays at a height, at most five seeds. Vision alone, without a filter; times are of the
// processor, one thread.
void BenchPadTrackers(flight::SeedRange seeds, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
