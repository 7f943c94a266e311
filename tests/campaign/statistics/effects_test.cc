// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/effects.h"

#include <fmt/format.h>

#include <numbers>

#include "base/statistics.h"
#include "tests/campaign/statistics/coverage.h"

namespace kestrel::campaign {
namespace {

using std::numbers::pi;

std::vector<double> Draw(RandomStream& random, int n) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(random.Uniform(-1, 1));
  return values;
}

// The mean of errors, and how far chance may take it: four deviations.
class Bias {
 public:
  void Add(double error) { errors_.push_back(error); }
  double mean() const { return Mean(errors_); }
  double Chance() const {
    const double n = static_cast<double>(errors_.size());
    return 4 * std::sqrt((Rms(errors_) * Rms(errors_) - mean() * mean()) / n);
  }

 private:
  std::vector<double> errors_;
};

TEST(RankCorrelation, WithoutTiesIsByTheDifferencesOfRanks) {
  const std::vector<double> x = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
                            y = {20, 10, 40, 30, 60, 50, 80, 70, 100, 90};
  EXPECT_NEAR(RankCorrelation(x, y)->value, 1 - 6 * 10.0 / (10 * 99), 1e-12);  // each rank is off by one
  const double r = RankCorrelation(x, y)->value, half = 1.959964 * std::sqrt((1 + r * r / 2) / 7);
  EXPECT_NEAR(RankCorrelation(x, y)->interval.low, std::tanh(std::atanh(r) - half), 1e-6);
  EXPECT_NEAR(RankCorrelation(x, y)->interval.high, std::tanh(std::atanh(r) + half), 1e-6);
}

TEST(RankCorrelation, TiesHaveTheMeanOfTheirRanks) {
  RandomStream random(3, "ties");
  std::vector<double> x, y;
  for (int i = 0; i < 40; ++i) {
    x.push_back(std::floor(random.Uniform(0, 5)));
    y.push_back(x.back() + std::floor(random.Uniform(0, 5)));
  }
  const auto ranks = [](const std::vector<double>& values) {  // by counting
    std::vector<double> all;
    for (const double v : values) {
      double below = 0, same = 0;
      for (const double w : values) below += w < v, same += w == v;
      all.push_back(below + (same + 1) / 2);
    }
    return all;
  };
  const auto a = ranks(x), b = ranks(y);
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    ab += (a[i] - Mean(a)) * (b[i] - Mean(b)), aa += std::pow(a[i] - Mean(a), 2),
        bb += std::pow(b[i] - Mean(b), 2);
  EXPECT_NEAR(RankCorrelation(x, y)->value, ab / std::sqrt(aa * bb), 1e-12);
}

std::vector<double> Ranks(int n) {
  std::vector<double> ranks;
  for (int i = 0; i < n; ++i) ranks.push_back(i);
  return ranks;
}

TEST(RankCorrelation, AndIndexThereIsNoneOfFewPairsOrOfWhatDoesNotVary) {
  const std::vector<double> nine = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_FALSE(RankCorrelation(nine, nine));
  EXPECT_FALSE(RankCorrelation(std::vector<double>(20, 1), std::vector<double>(20, 1)));
  EXPECT_FALSE(FirstOrderIndex(Ranks(49), Ranks(49)));
  EXPECT_NEAR(FirstOrderIndex(Ranks(50), Ranks(50))->value, 1, 1e-9);
  EXPECT_FALSE(FirstOrderIndex(Ranks(50), std::vector<double>(50, 1)));
}

TEST(RankCorrelation, ItsIntervalHoldsThatOfTheNormalDistributionAsOftenAsItSays) {
  const int simulations = 2000;
  for (const double rho : {0.0, 0.5, 0.9}) {
    const double truth = 6 / pi * std::asin(rho / 2);
    EXPECT_NEAR(Coverage(simulations, truth,
                         [&](RandomStream& random) {
                           std::vector<double> x, y;
                           for (int i = 0; i < 100; ++i) {
                             x.push_back(random.Normal());
                             y.push_back(rho * x.back() + std::sqrt(1 - rho * rho) * random.Normal());
                           }
                           return RankCorrelation(x, y)->interval;
                         }),
                0.955, Chance(simulations))
        << rho;
  }
}

// y = sqrt(S) x1 + sqrt(1 - S) x2 has the index S of x1.
TEST(FirstOrderIndex, OfALinearModelIsTheSquareOfItsPart) {
  const int simulations = 600, n = 300;
  for (const double index : {0.05, 0.3, 0.7, 0.95}) {
    Bias bias;
    const double coverage = Coverage(simulations, index, [&](RandomStream& random) {
      const auto x = Draw(random, n), other = Draw(random, n);
      std::vector<double> y;
      for (int i = 0; i < n; ++i)
        y.push_back(std::sqrt(index) * x[static_cast<std::size_t>(i)] +
                    std::sqrt(1 - index) * other[static_cast<std::size_t>(i)]);
      const Estimate estimate = *FirstOrderIndex(x, y);
      bias.Add(estimate.value - index);
      return estimate.interval;
    });
    EXPECT_GE(coverage, 0.94 - Chance(simulations)) << index;
    EXPECT_NEAR(bias.mean(), 0, 0.003 + bias.Chance()) << index;
  }
}

// Ishigami and Homma 1990: sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 over [-pi, pi]^3. Its indices by
// integration: V1 = (1 + 0.1 pi^4 / 5)^2 / 2, V2 = 49 / 8, V = V1 + V2 + 8 x 0.01 pi^8 / 225.
TEST(FirstOrderIndex, OfIshigamisFunctionIsTheKnownOne) {
  const double first = std::pow(1 + 0.1 * std::pow(pi, 4) / 5, 2) / 2, second = 49 / 8.0;
  const double all = first + second + 8 * 0.01 * std::pow(pi, 8) / 225;
  ASSERT_NEAR(first / all, 0.3139, 1e-4);
  ASSERT_NEAR(second / all, 0.4424, 1e-4);
  const int simulations = 400, n = 500;
  for (const auto& [key, truth] : {std::pair(0u, first / all), {1u, second / all}, {2u, 0.0}}) {
    Bias bias;
    const double coverage = Coverage(simulations, truth, [&, key = key, truth = truth](RandomStream& random) {
      const std::vector<double> x[] = {Draw(random, n), Draw(random, n), Draw(random, n)};
      std::vector<double> y;
      for (std::size_t i = 0; i < n; ++i)
        y.push_back(std::sin(pi * x[0][i]) * (1 + 0.1 * std::pow(pi * x[2][i], 4)) +
                    7 * std::pow(std::sin(pi * x[1][i]), 2));
      const Estimate estimate = *FirstOrderIndex(x[key], y);
      bias.Add(estimate.value - truth);
      return estimate.interval;
    });
    EXPECT_GE(coverage, 0.925 - Chance(simulations)) << key;
    EXPECT_NEAR(bias.mean(), 0, 0.003 + bias.Chance()) << key;
  }
}

TEST(FirstOrderIndex, IsTheSameOnALogarithmicScale) {
  RandomStream random(4, "scale");
  const auto x = Draw(random, 200);
  std::vector<double> y, grown;
  for (const double v : x) y.push_back(v * v + 0.2 * random.Normal()), grown.push_back(std::exp(5 * v));
  EXPECT_EQ(FirstOrderIndex(x, y)->value, FirstOrderIndex(grown, y)->value);
}

TEST(ShareBetweenGroups, IsTheVarianceOfTheGroupsLessChance) {
  // Two groups of six: means 1 and 3, within each three of mean - 1 and three of mean + 1. Within 12 of 10
  // degrees of freedom, in all 24 of 11.
  const std::vector<double> y = {0, 0, 0, 2, 2, 2, 2, 2, 2, 4, 4, 4};
  const std::vector<std::size_t> groups = {7, 7, 7, 7, 7, 7, 9, 9, 9, 9, 9, 9};
  EXPECT_NEAR(ShareBetweenGroups(groups, y)->value, 1 - (12 / 10.0) / (24 / 11.0), 1e-12);
  EXPECT_FALSE(ShareBetweenGroups(std::vector<std::size_t>(12, 1), y));
}

TEST(ShareBetweenGroups, ItsIntervalHoldsTheShareAsOftenAsItSays) {
  const int simulations = 1500, n = 300;
  for (const double share : {0.1, 0.5, 0.9}) {
    const double coverage = Coverage(simulations, share, [&](RandomStream& random) {
      std::vector<std::size_t> groups;
      std::vector<double> y;
      for (int i = 0; i < n; ++i) {
        groups.push_back(random.Bits() % 4);
        const double mean = (static_cast<double>(groups.back()) - 1.5) / std::sqrt(1.25);  // of variance 1
        y.push_back(std::sqrt(share) * mean + std::sqrt(1 - share) * random.Normal());
      }
      return ShareBetweenGroups(groups, y)->interval;
    });
    EXPECT_NEAR(coverage, 0.945, Chance(simulations)) << share;
  }
}

TEST(Effects, AreOfEveryKeyThatVariesOnWhateverRunsHaveTheMetric) {
  SampleTable table{{"seed", "wind.mean_m_s", "camera", "pad.yaw_deg"}, {}};
  std::vector<RunResult> results;
  RandomStream random(5, "effects");
  for (int row = 0; row < 200; ++row) {
    const double wind = random.Uniform(0, 6);
    const bool fisheye = random.Uniform(0, 1) < 0.5;
    table.rows.push_back(
        {fmt::format("{}", row), fmt::format("{}", wind), fisheye ? "fisheye" : "pinhole", "3"});
    RunResult result;
    result.row = row;
    result.status = wind > 5.5 ? RunStatus::kFailed : RunStatus::kPassed;
    result.metrics["error_m"] = wind + 0.1 * random.Normal();
    if (row >= 50) result.metrics["share"] = fisheye ? 1 : 0.5 + 0.1 * random.Normal();
    results.push_back(result);
  }
  const auto effects = EffectsOf(table, results, {"success", "error_m", "share"});
  ASSERT_EQ(effects.size(), 6u);  // two keys by three
  EXPECT_EQ(effects[0].key, "wind.mean_m_s");
  EXPECT_EQ(effects[0].of, "success");
  EXPECT_LT(effects[0].rank_correlation->interval.high, -0.1);
  EXPECT_GT(effects[1].rank_correlation->value, 0.95);
  EXPECT_GT(effects[1].first_order->interval.low, 0.95);
  EXPECT_EQ(effects[1].runs, 200);
  EXPECT_EQ(effects[2].runs, 150);
  EXPECT_EQ(effects[2].first_order->interval.low, 0);
  EXPECT_EQ(effects[5].key, "camera");
  EXPECT_FALSE(effects[5].numeric);
  EXPECT_FALSE(effects[5].rank_correlation);
  EXPECT_GT(effects[5].first_order->interval.low, 0.8);
  EXPECT_EQ(effects[4].first_order->interval.low, 0);

  // With four failures nothing is said of success.
  int failures = 0;
  for (RunResult& result : results)
    if (result.status == RunStatus::kFailed && ++failures > 4) result.status = RunStatus::kPassed;
  ASSERT_GE(failures, 4);
  EXPECT_EQ(EffectsOf(table, results, {"success"}).size(), 0u);
}

TEST(Effects, ANumberIsOneFromItsBeginningToItsEnd) {
  EXPECT_EQ(NumberIn("-1.5e-3"), -1.5e-3);
  for (const char* text : {"", "1 m", "true", "[1, 2]", "nan", "inf"}) EXPECT_FALSE(NumberIn(text)) << text;
}

}  // namespace
}  // namespace kestrel::campaign
