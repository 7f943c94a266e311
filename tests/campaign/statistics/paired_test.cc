// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/paired.h"

#include "base/statistics.h"
#include "tests/campaign/statistics/coverage.h"

namespace kestrel::campaign {
namespace {

TEST(McNemar, IsTheShareOfAllWaysToPartTheRowsThatDiffer) {
  EXPECT_EQ(McNemar({90, 0, 0, 10}), 1);
  EXPECT_NEAR(McNemar({90, 6, 0, 10}), 2 / 64.0, 1e-12);
  EXPECT_NEAR(McNemar({0, 1, 8, 0}), 2 * 10 / 512.0, 1e-12);
  EXPECT_EQ(McNemar({0, 3, 3, 0}), 1);
  // By counting all 2^12 ways that coins fall.
  int as_far = 0;
  for (unsigned way = 0; way < 1u << 12; ++way) {
    int heads = 0;
    for (int i = 0; i < 12; ++i) heads += (way >> i) & 1;
    as_far += std::abs(heads - 6) >= 4;
  }
  EXPECT_NEAR(McNemar({5, 2, 10, 5}), as_far / 4096.0, 1e-12);
}

// The likeliest probabilities of "only B" and "only A" that differ by d, by search.
double ScoreBySearch(const PairedEnds& e, double d) {
  const double n = static_cast<double>(e.rows()), b = static_cast<double>(e.only_b),
               c = static_cast<double>(e.only_a);
  const auto likelihood = [&](double q) {
    return b * std::log(q + d) + c * std::log(q) + (n - b - c) * std::log(1 - 2 * q - d);
  };
  double low = std::max(0.0, -d), high = (1 - d) / 2;
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3;
    if (likelihood(low + third) < likelihood(high - third))
      low += third;
    else
      high -= third;
  }
  const double q = (low + high) / 2;
  return (b - c - n * d) / std::sqrt(n * (2 * q + d - d * d));
}

TEST(ShareDifference, ItsEndsAreWhereTheScoreIsThatOfTheLevel) {
  for (const PairedEnds& e : {PairedEnds{36, 2, 12, 0}, {90, 3, 5, 2}, {400, 20, 4, 76}}) {
    const Estimate difference = ShareDifference(e);
    EXPECT_NEAR(ScoreBySearch(e, difference.interval.low), 1.959964, 1e-5);
    EXPECT_NEAR(ScoreBySearch(e, difference.interval.high), -1.959964, 1e-5);
    EXPECT_DOUBLE_EQ(difference.value,
                     static_cast<double>(e.only_b - e.only_a) / static_cast<double>(e.rows()));
  }
}

TEST(ShareDifference, TurnsWithItsSides) {
  const Interval one = ShareDifference({50, 7, 2, 9}).interval,
                 other = ShareDifference({50, 2, 7, 9}).interval;
  EXPECT_NEAR(one.low, -other.high, 1e-12);
  EXPECT_NEAR(one.high, -other.low, 1e-12);
  // Without a row that differs: as far as z^2 / (n + z^2) to either side.
  const double z2 = 1.959964 * 1.959964;
  EXPECT_NEAR(ShareDifference({100, 0, 0, 0}).interval.high, z2 / (100 + z2), 1e-6);
  EXPECT_NEAR(ShareDifference({100, 0, 0, 0}).interval.low, -z2 / (100 + z2), 1e-6);
}

TEST(ShareDifference, HoldsTheDifferenceAsOftenAsItSaysAndMcNemarIsWrongNoOftener) {
  const int simulations = 3000;
  for (const auto& [only_b, only_a] : {std::pair(0.1, 0.1), {0.3, 0.1}, {0.05, 0.02}}) {
    int claims = 0;
    const double coverage =
        Coverage(simulations, only_b - only_a, [&, b = only_b, a = only_a](RandomStream& random) {
          PairedEnds ends;
          for (int i = 0; i < 150; ++i) {
            const double u = random.Uniform(0, 1);
            ++(u < b ? ends.only_b : u < a + b ? ends.only_a : ends.both);
          }
          const Interval interval = ShareDifference(ends).interval;
          const bool claim = McNemar(ends) < 0.05;
          EXPECT_TRUE(!claim || !interval.Holds(0));  // the two never speak against each other
          claims += claim;
          return interval;
        });
    EXPECT_NEAR(coverage, 0.95, 0.01 + Chance(simulations)) << only_b;
    if (only_b == only_a) {
      EXPECT_LE(claims, (0.05 + Chance(simulations)) * simulations);
    }
  }
}

TEST(PairedDifferences, EqualOnesLeaveNoDoubt) {
  const std::vector<double> a = {1, 5, 2, 8, 3, 3}, b = {2, 6, 3, 9, 4, 4};
  const PairedDifferences d = DifferencesOf(a, b, 1, 0.99, 500);
  EXPECT_NEAR(d.mean.interval.low, 1, 1e-12);
  EXPECT_NEAR(d.mean.interval.high, 1, 1e-12);
  EXPECT_EQ(d.median.interval, (Interval{1, 1}));
  EXPECT_EQ(d.median.a, 3);
  EXPECT_EQ(d.median.b, 4);
  EXPECT_EQ(d.quantile_95.a, Quantile(a, 0.95));
}

TEST(PairedDifferences, OfTheMeanHaveStudentsInterval) {
  const PairedDifferences d = DifferencesOf({10, 20, 30, 40, 50}, {11, 22, 33, 44, 55}, 1, 0.99, 10);
  EXPECT_NEAR(d.mean.interval.low, 3 - 2.776445 * 1.5811388 / std::sqrt(5.0), 1e-6);  // t of 4, from tables
  EXPECT_NEAR(d.mean_stricter.high, 3 + 4.604095 * 1.5811388 / std::sqrt(5.0), 1e-6);
  EXPECT_EQ(d.mean.b - d.mean.a, 3);
}

TEST(PairedDifferences, TheSameSeedGivesTheSameBits) {
  RandomStream random(1, "bits");
  std::vector<double> a, b;
  for (int i = 0; i < 50; ++i) a.push_back(random.Normal()), b.push_back(random.Normal());
  const auto one = DifferencesOf(a, b, 5, 0.99, 300), same = DifferencesOf(a, b, 5, 0.99, 300),
             other = DifferencesOf(a, b, 6, 0.99, 300);
  EXPECT_EQ(one.median.interval, same.median.interval);
  EXPECT_EQ(one.quantile_95.interval, same.quantile_95.interval);
  EXPECT_NE(one.median.interval, other.median.interval);
}

// Of 10 rows, 2 of which are 0 and the others 1, a resample has z zeros, binomial of 10 and 1/5. Its median
// is 0 from 6 zeros on, with a probability of 0.6 %, and 1/2 with 5, of 2.6 %: there the 2.5 % lie.
TEST(PairedDifferences, AQuantileMayLieBetweenTwoSamples) {
  const std::vector<double> a(10, 0), b = {0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
  EXPECT_EQ(DifferencesOf(a, b, 1, 0.95, 20000).median.interval, (Interval{0.5, 1}));
}

// The same, by drawing rows and sorting them.
TEST(PairedDifferences, IntervalsOfQuantilesAreThoseOfResamplesMadeByHand) {
  RandomStream random(2, "by hand");
  std::vector<double> a, b;
  for (int i = 0; i < 80; ++i)
    a.push_back(random.Normal()), b.push_back(a.back() + std::exp(random.Normal()));
  std::vector<double> means, medians, high;
  for (int i = 0; i < 4000; ++i) {
    std::vector<double> of_a, of_b;
    for (int j = 0; j < 80; ++j) {
      const std::size_t row = random.Bits() % 80;
      of_a.push_back(a[row]), of_b.push_back(b[row]);
    }
    medians.push_back(Quantile(of_b, 0.5) - Quantile(of_a, 0.5));
    high.push_back(Quantile(of_b, 0.95) - Quantile(of_a, 0.95));
  }
  const PairedDifferences d = DifferencesOf(a, b, 1, 0.95, 4000);
  EXPECT_NEAR(d.median.interval.low, Quantile(medians, 0.025), 0.05);
  EXPECT_NEAR(d.median.interval.high, Quantile(medians, 0.975), 0.05);
  EXPECT_NEAR(d.quantile_95.interval.low, Quantile(high, 0.025), 0.15);
  EXPECT_NEAR(d.quantile_95.interval.high, Quantile(high, 0.975), 0.15);
}

TEST(PairedDifferences, IntervalsHoldTheDifferenceAsOftenAsTheySay) {
  const int simulations = 300, n = 100;
  RandomStream random(9, "coverage");
  int mean = 0, median = 0, quantile = 0;
  for (int i = 0; i < simulations; ++i) {
    std::vector<double> a, b;
    for (int j = 0; j < n; ++j) {
      a.push_back(random.Normal());
      b.push_back(0.3 + 0.8 * a.back() + 0.6 * random.Normal());
    }
    const PairedDifferences d = DifferencesOf(a, b, static_cast<std::uint64_t>(i), 0.95, 400);
    mean += d.mean.interval.Holds(0.3), median += d.median.interval.Holds(0.3),
        quantile += d.quantile_95.interval.Holds(0.3);
  }
  const double least = (0.94 - Chance(simulations)) * simulations;
  EXPECT_GE(mean, least);
  EXPECT_GE(median, least);  // of quantiles too wide rather than too narrow
  EXPECT_GE(quantile, least);
  EXPECT_LT(mean, simulations);
}

}  // namespace
}  // namespace kestrel::campaign
