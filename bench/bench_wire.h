// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

namespace kestrel::bench {

// Landings by the program for real aircraft over each of the three wires, one for each seed, in real time:
// how well it lands, and what the wires and the program add to the camera's latency (AddedLatency_s).
// Throws InputError where that program is not there. Records go to the folder.
void BenchWire(flight::SeedRange seeds, int jobs, const std::filesystem::path& folder,
               std::vector<records::Figure>& table);

// Each row of kFaults once for each seed, the wires in turn: how many went as written, and the slowest
// reaction. What did not is told on standard error.
void BenchLinkFaults(flight::SeedRange seeds, int jobs, const std::filesystem::path& folder,
                     std::vector<records::Figure>& table);

}  // namespace kestrel::bench
