// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// What it takes to show a flight while it flies (flight/live): how long a row is on its way to a viewer, what viewers
// cost the flight at its own speed, in pairs of flights one after the other, and whether it is the same flight to the
// last bit. Viewers are of this program, one thread each, and take all that a page takes; a browser is not in it.
// folder: of the records of each.
void BenchLive(const flight::SeedRange& seeds, const std::filesystem::path& folder,
               std::vector<records::Figure>& table);

}  // namespace kestrel::bench
