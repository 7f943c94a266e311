// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flight/simulated/fly_all.h"
#include "records/figures.h"

// The flights over the pad, judged by the truth.
namespace kestrel {

void BenchFlights(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchFisheye(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchDrift(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchHeights(SeedRange seeds, std::vector<Figure>& table);
void BenchSpeed(SeedRange seeds, std::vector<Figure>& table);

}  // namespace kestrel
