// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How much a machine does by one worker, by two, ... to one more than it has cores: short landings of a campaign, by
// the same worker processes; frames alone, by as many processes and by as many threads of one. Prints a table of
// it with what each is as a multiple of one worker's, and adds the same to the figures. The folder is for the campaigns,
// and is emptied before.
void BenchThroughput(const std::filesystem::path& folder, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
