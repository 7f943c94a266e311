// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

namespace kestrel::bench {

// Thesis 5.4.2: steps of where a balloon is wanted in the image, in a calm and in wind, and balloons that are
// carried about at up to 1 and 2 m/s; each by the coupled law (5.20) and by the decoupled one (5.25), from the
// same seeds.
void BenchFollow(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// Thesis 6.4.3: the four flights past a thing that stands still.
void BenchAvoid(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// Thesis 5.4 by the last image alone, and what each addition buys: a level camera, the outline, prediction, the
// target's velocity. And its two laws without any of them.
void BenchFollowSteps(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// Thesis 6.4 without any range: four passes by (6.29), ended by hand, and by growth and bearing rate.
void BenchAvoidSight(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
