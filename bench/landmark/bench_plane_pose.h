// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How near the estimates of a plane's pose come to the bound of Cramer and Rao, over 2,000 poses of the pad
// (bench/landmark/plane_pose_study.h): printed by distance, tilt and size as a table of its own; the figures are
// those over the whole study.
void BenchPlanePose(std::uint64_t seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
