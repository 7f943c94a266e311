// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How each detector of features finds a pad of which a part is in view, as after a loss: images of 640 x 480 over the
// airfield, drawn by rays, 40 with a part of the pad and 20 without for each seed, at most five
// seeds. Printed as a table of its own; times are of the processor, one thread.
void BenchFeatures(std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
