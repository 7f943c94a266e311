// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::bench {

// The study of Baker and Matthews (2004): the share of draws, one for each seed, in which the corners of a
// template of 100 x 100 pixels come to within 1 px (root mean square), by their displacement at the start, and
// the time of an image of 640 x 480 with its pyramid. Ours by each method beside OpenCV's ECC, on pictures of
// several kinds. Printed as a table of its own; the figures are of ICIA, the references those of ECC.
void BenchAlignment(flight::SeedRange seeds, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
