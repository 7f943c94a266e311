// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "bench/planar/planar_trackers.h"
#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// Trackers of a flat picture side by side on the seven factors of POT-210, on four kinds of pictures, with
// exactly known homographies: 180 images of 640 x 480 for each, at most five seeds. Printed as a table of its
// own; the figures are those of the first tracker beside the best of the peers. out: where an image of each sequence is left every
// second, with ours drawn on it; empty: nowhere.
void BenchPlanar(flight::SeedRange seeds, int jobs, const std::filesystem::path& out,
                 const std::function<std::vector<PlanarTracker>(const cv::Mat& picture)>& trackers,
                 std::vector<records::Figure>& table);

}  // namespace kestrel::bench
