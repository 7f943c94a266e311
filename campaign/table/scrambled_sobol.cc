// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/scrambled_sobol.h"

#include <boost/random/sobol.hpp>

#include "base/random.h"

namespace kestrel::campaign {
namespace {

constexpr int kBits = 53;  // of a double

// Nested uniform scrambling of the leading bits.
std::uint64_t Scramble(std::uint64_t x, std::uint64_t seed) {
  std::uint64_t turned = 0;
  for (int bit = 0; bit < kBits; ++bit) {
    const std::uint64_t before = bit == 0 ? 0 : x >> (64 - bit);
    // The leading 1 tells apart the same bits of another number of them.
    const std::uint64_t hash = RandomStream::Mix(seed ^ RandomStream::Mix(before | 1ull << bit));
    turned |= (hash >> 63) << (63 - bit);
  }
  return x ^ turned;
}

}  // namespace

std::vector<std::vector<double>> ScrambledSobol(int points, const std::vector<std::uint64_t>& seeds) {
  std::vector<std::vector<double>> columns(seeds.size());
  if (seeds.empty()) return columns;
  boost::random::sobol sobol(seeds.size());
  for (int i = 0; i < points; ++i) {
    for (std::size_t d = 0; d < seeds.size(); ++d) {
      const std::uint64_t x = i == 0 ? 0 : sobol();  // Boost leaves out the first point, zero
      columns[d].push_back(static_cast<double>(Scramble(x, seeds[d]) >> (64 - kBits)) * 0x1p-53);
    }
  }
  return columns;
}

}  // namespace kestrel::campaign
