// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// Thesis table 6.3: attitude and heading by our own and by the thesis's method on the same images, over the
// four flights.
void BenchAttitude(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// The camera's attitude in place of one that drifts, freezes or goes silent, a minute of each.
void BenchGyroFailure(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
