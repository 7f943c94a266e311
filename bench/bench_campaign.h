// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// What campaigns cost beside their flights, and what they lose when they are killed: short hovers, by one
// worker and by two, the same again in parts, and with the parent killed 50 times. runs: of one worker, over
// which its memory is watched. Results go to the folder, which is emptied first.
void BenchCampaign(int runs, const std::filesystem::path& folder, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
