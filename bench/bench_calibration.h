// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How well a calibration finds the camera that drew the images: a pinhole, a fisheye, a mirror and a double
// sphere, each before both boards, 30 images of 0.3 px blur and 2 grey levels of noise for each seed; at most
// five seeds, several at a time.
void BenchCalibration(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                      std::vector<records::Figure>& table);

}  // namespace kestrel::bench
