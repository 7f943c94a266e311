// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// Attitude from the skyline over a sweep of attitudes, heights and landscapes, without flying: 5,200 stills
// of 100 landscapes (bench/horizon/horizon_stills.h) through the camera of attitude_1, each measured by
// vision alone and with what gyros and a barometer would expect, and judged by the truth. The samples depend
// on the seed alone, the answers not on the number of jobs. Then fewer through lenses that look forward.
//
// In the folder: stills.csv with a row for each still, factors.csv with a row for each range of a factor, and
// pictures of both.
void BenchHorizon(std::uint64_t seed, int jobs, const std::filesystem::path& folder,
                  std::vector<records::Figure>& table);

}  // namespace kestrel::bench
