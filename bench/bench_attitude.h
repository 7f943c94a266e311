// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "flight/simulated/fly_all.h"
#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// What makes the flights attitude_1 to attitude_4 the thesis's: its helicopter, the camera on the platform at
// its nose, so high that the legs and skids stand before the ground and not before the horizon, a pilot who tilts
// by 8 degrees, and winters without snow, which to the thesis's sky weight is sky. With the thesis's own method
// beside ours.
std::vector<std::string> ThesisRig();

// Thesis table 6.3: attitude and heading by our own method over the four flights, and by the thesis's over the
// same on its own rig.
void BenchAttitude(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

// The camera's attitude in place of one that drifts, freezes or goes silent, a minute of each.
void BenchGyroFailure(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
