// SPDX-License-Identifier: Apache-2.0
#include "base/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kestrel {
namespace {

TEST(Statistics, OfFourSamples) {
  const std::vector<double> values = {4, 1, 3, 2};
  EXPECT_DOUBLE_EQ(Mean(values), 2.5);
  EXPECT_DOUBLE_EQ(Rms(values), std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(Largest(values), 4);
  EXPECT_DOUBLE_EQ(Quantile(values, 0), 1);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.9), 3.7);
  EXPECT_DOUBLE_EQ(Quantile(values, 1), 4);
}

TEST(Statistics, OfNoSamplesAreNoNumbers) {
  EXPECT_TRUE(std::isnan(Mean({})));
  EXPECT_TRUE(std::isnan(Rms({})));
  EXPECT_TRUE(std::isnan(Largest({})));
  EXPECT_TRUE(std::isnan(Quantile({}, 0.5)));
}

TEST(Statistics, QuantilesBearInfinities) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(Quantile({1, inf, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({1, inf, inf}, 0.75), inf);
}

}  // namespace
}  // namespace kestrel
