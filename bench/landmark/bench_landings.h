// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

namespace kestrel::bench {

// Landings by each way to follow a pad and on each kind of pad, and the carried cameras of thesis 3.4, judged by
// the truth.
void BenchLandings(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
