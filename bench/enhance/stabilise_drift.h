// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// A minute over one place, to and fro by a third of the image and shaken, held to the first image as a reference: how far
// what the reference shows has drifted by the end, truly. How the thesis does it, each image by the one before it, has
// no end to its drift.
void BenchReferenceDrift(std::uint64_t seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
