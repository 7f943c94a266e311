// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// What the estimators of homographies make of drawn pairs with outliers of 0 to 70 %, beside OpenCV's MAGSAC, and
// how near the solutions without outliers come to the truth: tables of their own.
void BenchHomographies(std::uint64_t seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
