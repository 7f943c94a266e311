// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// Video of a camera that shakes over flat ground, hovering, in transit and turning, stabilised in each way: residual
// jitter, distortion, stability, skew of rows, jumps and times, at most three seeds. out: where stills before and after
// are left; empty: nowhere.
void BenchStabilise(flight::SeedRange seeds, const std::filesystem::path& out,
                    std::vector<records::Figure>& table);

}  // namespace kestrel::bench
