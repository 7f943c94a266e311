// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// Mosaics of 450 images of a survey and panoramas of a turn, whose truth is known exactly: ground points in the mosaic's
// picture against an orthographic drawing of the same ground, chained alone and with loops, with poses and without;
// closure and directions of panoramas; projections against OpenCV's; times on one core. At most two seeds. out: where
// the pictures are left; empty: nowhere.
void BenchMosaic(flight::SeedRange seeds, const std::filesystem::path& out,
                 std::vector<records::Figure>& table);

}  // namespace kestrel::bench
