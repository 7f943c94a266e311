// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/intervals.h"

#include <algorithm>
#include <numeric>

#include "tests/campaign/statistics/coverage.h"

namespace kestrel::campaign {
namespace {

using ::testing::Ge;
using ::testing::Le;

// P(X <= k) by its definition.
double BinomialCdf(int k, int n, double p) {
  double sum = 0, ways = 1;
  for (int i = 0; i <= k; ++i) {
    sum += ways * std::pow(p, i) * std::pow(1 - p, n - i);
    ways = ways * (n - i) / (i + 1);
  }
  return sum;
}

TEST(ShareInterval, ZeroFailuresShowAShareFromTheKnownNumberOfRunsOn) {
  for (const auto& [share, one_sided, two_sided] :
       {std::tuple(0.95, 59, 72), {0.99, 299, 368}, {0.999, 2995, 3688}}) {
    EXPECT_GE(ShareAtLeast(one_sided, one_sided), share);
    EXPECT_LT(ShareAtLeast(one_sided - 1, one_sided - 1), share);
    EXPECT_GE(ShareInterval(two_sided, two_sided).low, share);
    EXPECT_LT(ShareInterval(two_sided - 1, two_sided - 1).low, share);
  }
}

TEST(ShareInterval, ItsEndsAreThoseOfTheBinomialDistribution) {
  for (const auto& [k, n] : {std::pair(1, 10), {7, 10}, {3, 25}, {48, 50}}) {
    const Interval interval = ShareInterval(k, n);
    EXPECT_NEAR(1 - BinomialCdf(k - 1, n, interval.low), 0.025, 1e-9);
    EXPECT_NEAR(BinomialCdf(k, n, interval.high), 0.025, 1e-9);
    EXPECT_NEAR(1 - BinomialCdf(k - 1, n, ShareAtLeast(k, n)), 0.05, 1e-9);
    EXPECT_NEAR(BinomialCdf(k, n, ShareAtMost(k, n)), 0.05, 1e-9);
  }
  EXPECT_EQ(ShareInterval(0, 0), (Interval{0, 1}));
  EXPECT_EQ(ShareInterval(0, 9).low, 0);
  EXPECT_EQ(ShareInterval(9, 9).high, 1);
}

TEST(ShareInterval, HoldsEveryProbabilityAtLeastAsOftenAsItSays) {
  const int n = 40;
  std::vector<Interval> intervals;
  for (int k = 0; k <= n; ++k) intervals.push_back(ShareInterval(k, n));
  for (double p = 0.01; p < 1; p += 0.01) {  // the coverage itself, without chance
    double coverage = 0;
    for (int k = 0; k <= n; ++k)
      if (intervals[static_cast<std::size_t>(k)].Holds(p))
        coverage += BinomialCdf(k, n, p) - (k > 0 ? BinomialCdf(k - 1, n, p) : 0);
    EXPECT_GE(coverage, 0.95) << p;
  }
}

TEST(Mean, OfSymmetricSamplesHasStudentsInterval) {
  const Estimate mean = MeanOf({1, 2, 3, 4, 5});
  EXPECT_EQ(mean.value, 3);
  EXPECT_NEAR(mean.interval.low, 3 - 2.776445 * 1.5811388 / std::sqrt(5.0), 1e-6);  // t of 4, from tables
  EXPECT_NEAR(mean.interval.high, 3 + 2.776445 * 1.5811388 / std::sqrt(5.0), 1e-6);
  EXPECT_EQ(MeanOf({2}).interval, Interval());
  EXPECT_EQ(MeanOf({2, 2}).interval, (Interval{2, 2}));
  EXPECT_TRUE(std::isnan(MeanOf({}).value));
}

TEST(Mean, OfSkewedSamplesHasTheIntervalOfHallsTransformation) {
  const std::vector<double> samples = {1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 9, 9, 9};  // mean 3
  const double n = 18, deviation = std::sqrt(138.0 / 17), skew = 594 / n / std::pow(138 / n, 1.5);
  const Estimate mean = MeanOf(samples);
  // The transformation itself, of the distance of each end from the mean.
  const auto g = [&](double end) {
    const double w = (3 - end) / deviation;
    return w + skew * w * w / 3 + skew * skew * w * w * w / 27 + skew / (6 * n);
  };
  EXPECT_NEAR(g(mean.interval.low), 2.109816 / std::sqrt(n), 1e-6);  // t of 17, from tables
  EXPECT_NEAR(g(mean.interval.high), -2.109816 / std::sqrt(n), 1e-6);
  EXPECT_GT(mean.interval.high - 3, 3 - mean.interval.low);
}

TEST(Mean, ItsIntervalHoldsTheMeanAsOftenAsItSays) {
  const int simulations = 3000;
  const auto of = [&](int n, double truth, auto&& draw) {
    return Coverage(simulations, truth, [&](RandomStream& random) {
      std::vector<double> samples;
      for (int i = 0; i < n; ++i) samples.push_back(draw(random));
      return MeanOf(samples).interval;
    });
  };
  const auto exponential = [](RandomStream& r) { return -std::log(1 - r.Uniform(0, 1)); };
  EXPECT_NEAR(of(30, 0, [](RandomStream& r) { return r.Normal(); }), 0.95, Chance(simulations));
  EXPECT_NEAR(of(30, 1, exponential), 0.95, Chance(simulations));
  EXPECT_NEAR(of(100, 1, exponential), 0.95, Chance(simulations));
  // Of a skewness of 6, some 2 % short.
  EXPECT_NEAR(of(100, std::exp(0.5), [](RandomStream& r) { return std::exp(r.Normal()); }), 0.935,
              0.015 + Chance(simulations));
}

// What lies in a range has its mean in it: no end is beyond, and one that would be is not given.
TEST(Mean, NoEndIsBeyondWhatWasSeen) {
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(MeanOf({0.5, 1}).interval, Interval());  // Student's is -2.4 to 3.9
  EXPECT_EQ(MeanOf({0.9, 1, 1}).interval, Interval());
  RandomStream random(1, "shares");
  int given = 0;
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> shares(static_cast<std::size_t>(random.Uniform(2, 40)));
    for (double& x : shares) x = std::min(1.0, random.Uniform(0.8, 1.3));
    const Interval interval = MeanOf(shares).interval;
    EXPECT_TRUE(interval.high <= 1 || interval.high == none);
    EXPECT_TRUE(interval.low >= 0 || interval.low == -none);
    given += interval.high <= 1 && interval.low >= 0;
  }
  EXPECT_GT(given, 500);
}

std::vector<double> Ranks(int n) {
  std::vector<double> samples(static_cast<std::size_t>(n));
  std::iota(samples.begin(), samples.end(), 1);
  std::reverse(samples.begin(), samples.end());
  return samples;
}

TEST(QuantileInterval, LiesBetweenTheKnownRanks) {
  EXPECT_EQ(QuantileOf(Ranks(100), 0.5).value, 50.5);
  EXPECT_EQ(QuantileOf(Ranks(100), 0.5).interval, (Interval{40, 61}));  // tables of order statistics
  EXPECT_EQ(QuantileOf(Ranks(6), 0.5).interval, (Interval{1, 6}));      // 1 - 2 / 2^6 = 96.9 %
  EXPECT_EQ(QuantileOf(Ranks(5), 0.5).interval, Interval());            // 93.8 % is the most that there is
  // The same numbers as of runs without a failure: 0.95^72 is below 2.5 %, 0.95^71 is not.
  EXPECT_EQ(QuantileOf(Ranks(72), 0.95).interval.high, 72);
  EXPECT_EQ(QuantileOf(Ranks(71), 0.95).interval.high, std::numeric_limits<double>::infinity());
  EXPECT_EQ(QuantileOf(Ranks(72), 0.05).interval.low, 1);
  EXPECT_EQ(QuantileOf(Ranks(71), 0.05).interval.low, -std::numeric_limits<double>::infinity());
}

TEST(QuantileInterval, ItsRanksAreTheNarrowestOfWhichTheBinomialDistributionSaysSo) {
  for (const int n : {30, 77, 200})
    for (const double q : {0.1, 0.5, 0.9}) {
      const Interval interval = QuantileOf(Ranks(n), q).interval;
      if (std::isfinite(interval.low)) {
        EXPECT_LE(BinomialCdf(static_cast<int>(interval.low) - 1, n, q), 0.025);
        EXPECT_GT(BinomialCdf(static_cast<int>(interval.low), n, q), 0.025);
      }
      if (std::isfinite(interval.high)) {
        EXPECT_LE(1 - BinomialCdf(static_cast<int>(interval.high) - 1, n, q), 0.025);
        EXPECT_GT(1 - BinomialCdf(static_cast<int>(interval.high) - 2, n, q), 0.025);
      }
    }
}

TEST(QuantileInterval, HoldsTheQuantileAtLeastAsOftenAsItSays) {
  const int simulations = 2000;
  for (const double q : {0.05, 0.5, 0.95}) {
    const double coverage = Coverage(simulations, -std::log(1 - q), [&](RandomStream& random) {
      std::vector<double> samples;
      for (int i = 0; i < 120; ++i) samples.push_back(-std::log(1 - random.Uniform(0, 1)));
      return QuantileOf(samples, q).interval;
    });
    EXPECT_THAT(coverage, testing::AllOf(Ge(0.95 - Chance(simulations)), Le(0.995))) << q;
  }
}

TEST(QuantileInterval, InfiniteSamplesStandAtTheirEnd) {
  std::vector<double> samples = Ranks(200);
  samples[0] = samples[1] = std::numeric_limits<double>::infinity();  // the greatest two
  EXPECT_EQ(QuantileOf(samples, 0.9).interval, QuantileOf(Ranks(200), 0.9).interval);
  EXPECT_EQ(QuantileOf(samples, 0.995).interval.high, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace kestrel::campaign
