// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel {

// Thesis table 6.3: attitude and heading by our own and by the thesis's method on the same images, over the
// four flights.
void BenchAttitude(SeedRange seeds, int jobs, std::vector<Figure>& table);

// The camera's attitude in place of one that drifts, freezes or goes silent, a minute of each.
void BenchGyroFailure(SeedRange seeds, int jobs, std::vector<Figure>& table);

}  // namespace kestrel
