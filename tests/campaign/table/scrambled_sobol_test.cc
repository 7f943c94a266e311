// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/scrambled_sobol.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "base/random.h"
#include "tests/campaign/table/kolmogorov.h"

namespace kestrel::campaign {
namespace {

TEST(ScrambledSobol, TheFirstTwoDimensionsHaveOnePointInEveryElementaryBox) {
  // The definition of a (0, 6, 2)-net in base 2, which scrambling keeps.
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const auto columns = ScrambledSobol(64, {seed, seed + 100});
    for (int bits = 0; bits <= 6; ++bits) {
      std::set<std::pair<int, int>> boxes;
      for (int i = 0; i < 64; ++i)
        boxes.emplace(static_cast<int>(std::ldexp(columns[0][i], bits)),
                      static_cast<int>(std::ldexp(columns[1][i], 6 - bits)));
      EXPECT_EQ(boxes.size(), 64u) << bits;
    }
  }
}

TEST(ScrambledSobol, EveryDimensionHasOnePointInEachStratum) {
  std::vector<std::uint64_t> seeds(40);
  for (std::size_t d = 0; d < seeds.size(); ++d) seeds[d] = 7 * d;
  for (const auto& column : ScrambledSobol(256, seeds)) {
    std::set<int> strata;
    for (const double u : column) strata.insert(static_cast<int>(256 * u));
    EXPECT_EQ(strata.size(), 256u);
  }
}

TEST(ScrambledSobol, EachPointIsUniformOverTheSeeds) {
  for (const int point : {0, 1, 37}) {
    std::vector<double> values;
    for (std::uint64_t seed = 0; seed < 2000; ++seed)
      values.push_back(ScrambledSobol(point + 1, {11, RandomStream::Mix(seed)})[1][point]);
    EXPECT_LT(KolmogorovDistance(values, [](double u) { return u; }), 1.95);
  }
}

TEST(ScrambledSobol, ItIntegratesFarBetterThanIndependentSamples) {
  // Of the product of 4 factors with mean 1; the root mean square over 30 seeds. Its variance is known:
  // (1 + 1/3)^4 - 1 by 256 points.
  const int points = 256, seeds = 30;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const auto u = ScrambledSobol(points, {4 * seed, 4 * seed + 1, 4 * seed + 2, 4 * seed + 3});
    double mean = 0;
    for (int i = 0; i < points; ++i) mean += 16 * u[0][i] * u[1][i] * u[2][i] * u[3][i] / points;
    sum += (mean - 1) * (mean - 1);
  }
  const double independent = std::sqrt((std::pow(4.0 / 3, 4) - 1) / points);
  EXPECT_LT(std::sqrt(sum / seeds), 0.1 * independent);
}

}  // namespace
}  // namespace kestrel::campaign
