// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How many images a second of 1024 x 780 pixels are held to a reference by a homography of 1,000 points, as the thesis
// did on a graphics card (4.2): on one core, on two, and by OpenCL where there is a device. Their drawing is not timed.
void TimeStabiliser(std::uint64_t seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
