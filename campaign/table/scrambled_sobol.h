// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace kestrel::campaign {

// The first points of Sobol's sequence (direction numbers of Joe and Kuo 2008, as Boost has them), zero among
// them, each dimension scrambled as Owen (1995) has it: a bit of a number is turned over by a hash of its
// seed and of the bits before it. The first 2^k of a dimension have one point in each of 2^k equal strata, as
// before, whatever the seed; powers of two are its best sizes. At most 3667 dimensions.
// seeds: of each dimension. Returns [dimension][point], in [0, 1).
std::vector<std::vector<double>> ScrambledSobol(int points, const std::vector<std::uint64_t>& seeds);

}  // namespace kestrel::campaign
