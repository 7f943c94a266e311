// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// CamShift alone, CamShift with the fit of the outline, KCF and CSRT on the same clips: a red balloon of 0.5
// m over the airfield (models/targets/balloon.xml), drawn by rays, each nuisance by itself, 100 images of 640
// x 480 for each seed, at most five seeds. Printed as a table of its own, by the true outline; the figures
// are those of the outline's fit beside the best of the others. Times are of the processor, one thread.
void BenchTrackers(std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
