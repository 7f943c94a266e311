// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// Trackers of a flat picture side by side on the seven factors of POT-210, on four kinds of pictures, with
// exactly known homographies: 180 images of 640 x 480 for each, at most five seeds. Printed as a table of its
// own; the figures are ours beside the best of the others. out: where an image of each sequence is left every
// second, with ours drawn on it; empty: nowhere.
void BenchPlanar(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                 const std::filesystem::path& out, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
