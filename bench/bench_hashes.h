// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// The hashes of states and images of every scenario for each seed, and how many differ from those that are
// kept in a file: what must not change when code is moved. The file is a CSV table (scenario, seed,
// state_hash, image_hash) below lines that say by which machine it was made, as "# name: value"; where there is none, it
// is written. By another machine hashes may differ (sim/machine.h): then how many do is told without a target.
// Throws std::runtime_error if a flight breaks off.
void BenchHashes(flight::SeedRange seeds, int jobs, const std::filesystem::path& kept,
                 std::vector<records::Figure>& table);

}  // namespace kestrel::bench
