// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "scenarios/figures.h"
#include "scenarios/fly_all.h"

// The flights over the pad, judged by the truth.
namespace kestrel {

void BenchFlights(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchFisheye(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchDrift(SeedRange seeds, int jobs, std::vector<Figure>& table);
void BenchHeights(SeedRange seeds, std::vector<Figure>& table);
void BenchSpeed(SeedRange seeds, std::vector<Figure>& table);

}  // namespace kestrel
