// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/distribution.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;

double NumberAt(const Distribution& distribution, double u) {
  return std::strtod(ValueAt(distribution, u).c_str(), nullptr);
}

double Phi(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Each distribution by its own definition: the share of the values below the value at u is u.
TEST(Distribution, TheShareBelowTheValueAtAShareIsThatShare) {
  for (double u = 0.0005; u < 1; u += 0.001) {
    EXPECT_NEAR((NumberAt(Uniform{-2, 6}, u) + 2) / 8, u, 1e-12);
    EXPECT_NEAR(std::log10(NumberAt(LogUniform{0.01, 100}, u) / 0.01) / 4, u, 1e-12);
    EXPECT_NEAR(Phi((NumberAt(Normal{3, 0.5}, u) - 3) / 0.5), u, 1e-12);
    const double cut = NumberAt(TruncatedNormal{4, 2, 0, 10}, u);
    EXPECT_NEAR((Phi((cut - 4) / 2) - Phi(-2)) / (Phi(3) - Phi(-2)), u, 1e-12);
  }
}

TEST(Distribution, ATruncatedNormalKeepsItsDigitsFarInEitherTail) {
  // 8 deviations off, where the share of the whole above it is 6e-16.
  for (const double u : {0.001, 0.3, 0.7, 0.999}) {
    const double z = NumberAt(TruncatedNormal{0, 1, 8, 9}, u);
    EXPECT_NEAR((Phi(-8) - Phi(-z)) / (Phi(-8) - Phi(-9)), u, 1e-9);
    EXPECT_NEAR(NumberAt(TruncatedNormal{0, 1, -9, -8}, 1 - u), -z, 1e-12);
  }
}

TEST(Distribution, NoValueLeavesTheExtremes) {
  const std::vector<Distribution> all = {Uniform{0.1, 0.3}, LogUniform{0.02, 0.12}, Normal{1, 3},
                                         TruncatedNormal{4, 2, 0, 10}, TruncatedNormal{0, 0.1, 0.7, 0.8}};
  for (const Distribution& d : all) {
    const double low = std::stod(Extremes(d)[0]), high = std::stod(Extremes(d)[1]);
    for (const double u : {0.0, 0x1p-53, 0.5, 1 - 0x1p-53}) {
      EXPECT_GE(NumberAt(d, u), low);
      EXPECT_LE(NumberAt(d, u), high);
    }
    EXPECT_LT(NumberAt(d, 0), NumberAt(d, 1 - 0x1p-53));
  }
  EXPECT_THAT(Extremes(Normal{1, 3}), ElementsAre("-29", "31"));
  EXPECT_THAT(Extremes(Choice{{"a", "b"}}), ElementsAre("a", "b"));
  EXPECT_THAT(Extremes(Grid{{"1", "2", "3"}}), ElementsAre("1", "2", "3"));
}

TEST(Distribution, AChoiceGivesEachTheSameShare) {
  const Choice choice{{"a", "b", "c"}};
  EXPECT_EQ(ValueAt(choice, 0), "a");
  EXPECT_EQ(ValueAt(choice, 1.0 / 3 - 1e-9), "a");
  EXPECT_EQ(ValueAt(choice, 1.0 / 3 + 1e-9), "b");
  EXPECT_EQ(ValueAt(choice, 2.0 / 3 + 1e-9), "c");
  EXPECT_EQ(ValueAt(choice, 1 - 0x1p-53), "c");
}

TEST(Distribution, NumbersReadBackToTheSameBits) {
  const double low = 0.1, high = 0.7, u = 0.123456789012345678;
  EXPECT_EQ(NumberAt(Uniform{low, high}, u), low + u * (high - low));
}

}  // namespace
}  // namespace kestrel::campaign
