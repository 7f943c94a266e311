// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

// The flights over the pad, judged by the truth.
namespace kestrel::bench {

void BenchFlights(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);
void BenchFisheye(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);
void BenchDrift(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table);
void BenchHeights(flight::SeedRange seeds, std::vector<records::Figure>& table);
void BenchSpeed(flight::SeedRange seeds, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
