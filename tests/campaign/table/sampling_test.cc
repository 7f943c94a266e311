// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/sampling.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>
#include <set>

#include "tests/campaign/table/kolmogorov.h"

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;

CampaignPlan PlanOf(const std::string& sampling, int runs, std::uint64_t seed = 1) {
  CampaignPlan plan;
  plan.sampling = sampling, plan.runs = runs, plan.seed = seed;
  plan.vary = {{"a", Uniform{0, 1}}, {"b", Normal{5, 2}}, {"c", LogUniform{0.01, 1}}};
  return plan;
}

std::vector<std::string> TextsOf(const SampleTable& table, const std::string& key) {
  const auto k = std::find(table.keys.begin(), table.keys.end(), key) - table.keys.begin();
  std::vector<std::string> texts;
  for (const auto& row : table.rows) texts.push_back(row[k]);
  return texts;
}

std::vector<double> ColumnOf(const SampleTable& table, const std::string& key) {
  std::vector<double> numbers;
  for (const std::string& text : TextsOf(table, key)) numbers.push_back(std::stod(text));
  return numbers;
}

std::vector<double> Ranks(const std::vector<double>& values) {
  std::vector<double> ranks;
  for (const double v : values)
    ranks.push_back(static_cast<double>(
        std::count_if(values.begin(), values.end(), [&](double other) { return other < v; })));
  return ranks;
}

// Spearman's, by its definition.
double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = Ranks(a), y = Ranks(b);
  const double middle = (static_cast<double>(x.size()) - 1) / 2;
  double xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    xy += (x[i] - middle) * (y[i] - middle), xx += (x[i] - middle) * (x[i] - middle);
  return xy / xx;
}

double CdfOf(const std::string& key, double x) {
  if (key == "a") return x;
  if (key == "b") return boost::math::cdf(boost::math::normal(5, 2), x);
  return std::log10(x) / 2 + 1;
}

const std::vector<std::string> kSamplings = {"independent", "latin_hypercube", "sobol"};

TEST(Sampling, TheMarginalsAreThoseAskedFor) {
  for (const std::string& sampling : kSamplings) {
    CampaignPlan plan = PlanOf(sampling, 1000);
    for (const bool correlated : {false, true}) {
      if (correlated) plan.correlated = {{{"a", "c", "b"}, 0.6}};
      const SampleTable table = DrawTable(plan);
      EXPECT_THAT(table.keys, ElementsAre("seed", "a", "b", "c"));
      for (const char* key : {"a", "b", "c"}) {
        EXPECT_LT(KolmogorovDistance(ColumnOf(table, key), [&](double x) { return CdfOf(key, x); }), 1.95)
            << sampling << ' ' << key;
      }
    }
  }
}

TEST(Sampling, ALatinHypercubeHasOneRowInEachStratumAlsoWhenCorrelated) {
  CampaignPlan plan = PlanOf("latin_hypercube", 137);
  for (const double r : {0.0, 0.8}) {
    if (r > 0) plan.correlated = {{{"b", "a"}, r}};
    const SampleTable table = DrawTable(plan);
    for (const char* key : {"a", "b", "c"}) {
      std::set<int> strata;
      for (const double x : ColumnOf(table, key)) strata.insert(static_cast<int>(137 * CdfOf(key, x)));
      EXPECT_EQ(strata.size(), 137u) << key;
    }
  }
}

TEST(Sampling, AGroupHasTheRankCorrelationAskedFor) {
  for (const std::string& sampling : kSamplings) {
    for (const double r : {-0.4, 0.3, 0.6, 0.95}) {
      CampaignPlan plan = PlanOf(sampling, 2000);
      plan.correlated = {{{"a", "b", "c"}, r}};
      const SampleTable table = DrawTable(plan);
      for (const auto& [x, y] : {std::pair("a", "b"), std::pair("b", "c"), std::pair("a", "c")}) {
        // 4 standard deviations of the estimate of 2000 samples.
        EXPECT_NEAR(RankCorrelation(ColumnOf(table, x), ColumnOf(table, y)), r, 4 * 1.06 / std::sqrt(2000))
            << sampling;
      }
    }
  }
}

TEST(Sampling, WhatIsNotInAGroupIsNotCorrelated) {
  for (const std::string& sampling : kSamplings) {
    const SampleTable table = DrawTable(PlanOf(sampling, 2000));
    EXPECT_NEAR(RankCorrelation(ColumnOf(table, "a"), ColumnOf(table, "b")), 0, 4 / std::sqrt(2000));
  }
}

TEST(Sampling, TheLeastCorrelationOfAGroupIsWhereItsMatrixTurnsSingular) {
  EXPECT_DOUBLE_EQ(CopulaCorrelation(1), 1);
  EXPECT_DOUBLE_EQ(CopulaCorrelation(0), 0);
  for (const int keys : {2, 3, 7}) {
    const double least = CopulaCorrelation(MinRankCorrelation(keys));
    EXPECT_NEAR(1 + (keys - 1) * least, 0, 1e-12);  // the matrix's least eigenvalue
  }
}

TEST(Sampling, ATableDependsOnThePlanAlone) {
  for (const std::string& sampling : kSamplings) {
    EXPECT_EQ(HashOf(DrawTable(PlanOf(sampling, 50))), HashOf(DrawTable(PlanOf(sampling, 50))));
    EXPECT_NE(HashOf(DrawTable(PlanOf(sampling, 50))), HashOf(DrawTable(PlanOf(sampling, 50, 2))));
    const SampleTable one = DrawTable(PlanOf(sampling, 50)), other = DrawTable(PlanOf(sampling, 50, 2));
    for (const char* key : {"seed", "a", "b"}) EXPECT_NE(TextsOf(one, key), TextsOf(other, key));
  }
}

TEST(Sampling, AnotherKeyLeavesTheOthersAsTheyWere) {
  for (const std::string& sampling : kSamplings) {
    CampaignPlan plan = PlanOf(sampling, 50);
    const SampleTable before = DrawTable(plan);
    plan.vary["bb"] = Uniform{0, 1};
    const SampleTable after = DrawTable(plan);
    for (const char* key : {"seed", "a", "b"}) EXPECT_EQ(TextsOf(before, key), TextsOf(after, key));
    EXPECT_EQ(TextsOf(before, "c") == TextsOf(after, "c"), sampling != "sobol");
  }
}

TEST(Sampling, TheFirstOfMoreRunsAreThoseOfFewer) {
  for (const std::string sampling : {"independent", "sobol"}) {
    CampaignPlan plan = PlanOf(sampling, 50);
    plan.vary["d"] = Grid{{"1", "2", "3"}};
    plan.correlated = {{{"a", "b"}, 0.5}};
    const SampleTable few = DrawTable(plan);
    plan.runs = 80;
    SampleTable more = DrawTable(plan);
    EXPECT_EQ(more.rows.size(), 240u);
    more.rows.resize(150);
    EXPECT_EQ(more.rows, few.rows);
  }
}

TEST(Sampling, EveryPointOfTheGridsComesAsOftenAndInTurn) {
  CampaignPlan plan = PlanOf("latin_hypercube", 4);
  plan.vary["g"] = Grid{{"1", "2"}};
  plan.vary["h"] = Grid{{"x", "y", "z"}};
  const SampleTable table = DrawTable(plan);
  ASSERT_EQ(table.rows.size(), 24u);
  const auto g = TextsOf(table, "g"), h = TextsOf(table, "h");
  std::map<std::pair<std::string, std::string>, std::set<int>> strata;
  const std::vector<double> a = ColumnOf(table, "a");
  for (std::size_t i = 0; i < 24; ++i) strata[{g[i], h[i]}].insert(static_cast<int>(4 * a[i]));
  EXPECT_EQ(strata.size(), 6u);
  for (const auto& [point, at] : strata) EXPECT_EQ(at.size(), 4u);  // a hypercube at each point
  const auto point = [&](int i) { return std::pair(g[i], h[i]); };
  EXPECT_EQ(
      (std::vector{point(0), point(1), point(3), point(6)}),
      (std::vector<std::pair<std::string, std::string>>{{"1", "x"}, {"1", "y"}, {"2", "x"}, {"1", "x"}}));
}

TEST(Sampling, NoTwoRowsHaveTheSameSeed) {
  std::set<std::uint64_t> seeds;
  for (int row = 0; row < 10000; ++row) seeds.insert(SeedOfRow(1, row));
  EXPECT_EQ(seeds.size(), 10000u);
  EXPECT_NE(SeedOfRow(1, 0), SeedOfRow(2, 0));
  EXPECT_EQ(TextsOf(DrawTable(PlanOf("sobol", 3)), "seed")[2], std::to_string(SeedOfRow(1, 2)));
}

TEST(Sampling, ASeedThatVariesIsTheFirstColumnToo) {
  CampaignPlan plan = PlanOf("independent", 1);
  plan.vary["seed"] = Grid{{"7", "9"}};
  const SampleTable table = DrawTable(plan);
  EXPECT_THAT(table.keys, ElementsAre("seed", "a", "b", "c"));
  EXPECT_THAT(TextsOf(table, "seed"), ElementsAre("7", "9"));
}

}  // namespace
}  // namespace kestrel::campaign
