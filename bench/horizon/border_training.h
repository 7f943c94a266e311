// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "bench/horizon/bench_photographs.h"
#include "records/figures.h"

namespace kestrel::bench {

// Fits the weights by which BorderBelief tells the horizon from other straight lines, and prints them: a logistic model
// with a ridge, of all lines that StraightSkyline looks at in labelled photographs (as they are, grey, and with two
// other tone curves) and in stills of Kestrel's landscapes through an ordinary lens, drawn by the seed. A line is right
// within a degree and a half. Into the table go, of photographs and of stills, how many are answered and how far off
// the answers are by weights that were fitted without a fifth of the flights and landscapes, on that fifth; and by the
// weights in use.
void TrainBorderBelief(const std::vector<Photograph>& photographs, double fov_deg, std::uint64_t seed,
                       int jobs, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
