// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/comparison.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/diagnostics.h"
#include "tests/campaign/example_campaign.h"
#include "tests/campaign/statistics/coverage.h"

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kResamples = 200;

// The same rows with another gain, which changes every touch-down by so much.
CampaignResults WithGain(const CampaignResults& a, double times, double add = 0) {
  CampaignResults b = a;
  b.identity.scenario.replace(b.identity.scenario.find("0.6"), 3, "0.8");
  for (RunResult& run : b.results)
    if (const auto found = run.metrics.find("touchdown_error_m"); found != run.metrics.end())
      found->second = times * found->second + add;
  return b;
}

TEST(Compare, ASmallerErrorOnTheSameRowsIsBetterAndALargerOneWorse) {
  const CampaignResults a = ExampleCampaign();
  const Comparison better = Compare(a, WithGain(a, 0.8), {}, 1, kResamples);
  EXPECT_EQ(better.verdict, Verdict::kBetter);
  EXPECT_EQ(better.success_verdict, Verdict::kNotShown);
  EXPECT_THAT(better.differs, ElementsAre("pilot.lambda: 0.6 in A, 0.8 in B"));
  EXPECT_THAT(better.sentence, StartsWith("B is better than A in touchdown_error_m ("));
  ASSERT_EQ(better.metrics.size(), 2u);
  EXPECT_EQ(better.metrics[1].verdict, Verdict::kNotShown);  // not a bit of difference
  const Comparison worse = Compare(WithGain(a, 0.8), a, {}, 1, kResamples);
  EXPECT_EQ(worse.verdict, Verdict::kWorse);
  EXPECT_THAT(worse.sentence, StartsWith("B is worse than A in touchdown_error_m ("));
  EXPECT_EQ(worse.metrics[0].differences.mean.interval.low,
            -better.metrics[0].differences.mean.interval.high);
}

TEST(Compare, SaysOnWhatOtherMachineOneWasFlown) {
  CampaignResults a = ExampleCampaign(), b = a;
  a.identity.machine = {{"instruction_set", "avx512"}, {"mujoco", "2.2.2"}};
  EXPECT_THAT(Compare(a, b, {}, 1, kResamples).differs, ElementsAre("machine: that of B is not known"));
  b.identity.machine = {{"instruction_set", "avx2"}, {"mujoco", "2.2.2"}};
  EXPECT_THAT(Compare(a, b, {}, 1, kResamples).differs,
              ElementsAre("machine/instruction_set: avx512 in A, avx2 in B"));
}

TEST(Compare, OfThoseThatSpeakAgainstEachOtherNothingIsShown) {
  const CampaignResults a = ExampleCampaign();
  CampaignResults b = WithGain(a, 0.8);
  for (RunResult& run : b.results)
    if (run.metrics.contains("fix_share")) run.metrics["fix_share"] -= 0.1;
  const Comparison c = Compare(a, b, {}, 1, kResamples);
  EXPECT_EQ(c.verdict, Verdict::kNotShown);
  EXPECT_THAT(c.sentence,
              StartsWith("Not shown that B is better or worse than A: better in touchdown_error_m"));
  EXPECT_THAT(c.sentence, HasSubstr("worse in fix_share"));
}

TEST(Compare, OfWhatHasNoBetterOrWorseItSaysThatItDiffers) {
  const CampaignResults a = ExampleCampaign();
  CampaignResults b = a;
  for (RunResult& run : b.results) run.metrics["path_m"] = 2 + std::cos(static_cast<double>(run.row));
  CampaignResults longer = b;
  for (RunResult& run : longer.results) run.metrics["path_m"] += 0.5;
  const Comparison c = Compare(b, longer, {"path_m", "fix_share", "path_m"}, 1, kResamples);
  EXPECT_THAT(c.metrics, testing::SizeIs(2));
  EXPECT_EQ(c.verdict, Verdict::kNotShown);
  EXPECT_THAT(c.sentence, HasSubstr("; other in path_m (2.5 against 2 in the mean), which no criterion"));
  EXPECT_THAT(c.sentence, testing::Not(HasSubstr("no metric differs")));
  EXPECT_EQ(nlohmann::json::parse(ToJson(c)).at("metrics").at(0).at("differs"), true);
  EXPECT_THAT(Compare(b, b, {"path_m"}, 1, kResamples).sentence, HasSubstr("and no metric differs"));
}

// Of 24 rows 4 against none: the score interval leaves 0 out, the exact test does not.
TEST(Compare, TheExactTestDecidesWhereTheIntervalSaysOtherwise) {
  CampaignResults a = ExampleCampaign();
  a.results.resize(24);
  for (RunResult& run : a.results) run.status = run.row < 20 ? RunStatus::kPassed : RunStatus::kFailed;
  CampaignResults b = a;
  for (RunResult& run : b.results)
    if (run.row < 4) run.status = RunStatus::kFailed;
  const Comparison c = Compare(a, b, {}, 1, kResamples);
  EXPECT_EQ(c.chance, 0.125);
  EXPECT_LT(c.success.interval.high, 0);
  EXPECT_EQ(c.verdict, Verdict::kNotShown);
  EXPECT_THAT(c.sentence, HasSubstr("McNemar p = 0.12), which is exact and decides"));
}

TEST(Compare, SuccessSpeaksBeforeTheMetrics) {
  const CampaignResults a = ExampleCampaign();
  CampaignResults b = WithGain(a, 1.2);
  for (RunResult& run : b.results) run.status = RunStatus::kPassed;
  const Comparison c = Compare(a, b, {}, 1, kResamples);
  EXPECT_EQ(c.ends.only_a, 0);
  EXPECT_GT(c.ends.only_b, 5);
  EXPECT_EQ(c.ends.both + c.ends.only_b, 300);
  EXPECT_EQ(c.verdict, Verdict::kBetter);
  EXPECT_THAT(c.sentence, StartsWith("B is better than A: 100.0 % against "));
  EXPECT_THAT(c.sentence, HasSubstr("; worse in touchdown_error_m ("));
}

TEST(Compare, TheSameAgainIsNotShownToBeBetter) {
  const CampaignResults a = ExampleCampaign();
  const Comparison c = Compare(a, a, {}, 1, kResamples);
  EXPECT_EQ(c.verdict, Verdict::kNotShown);
  EXPECT_EQ(c.chance, 1);
  EXPECT_EQ(c.metrics[0].differences.mean.interval, (Interval{0, 0}));
  EXPECT_THAT(c.sentence, StartsWith("Not shown that B is better or worse than A: "));
  EXPECT_THAT(ToText(c), HasSubstr("the two are of the same settings and version"));
}

// Where chance alone parts the two, better or worse is said of success and of metrics once in twenty each at
// most.
TEST(Compare, ClaimsNoDifferenceWhereThereIsNone) {
  const int simulations = 150;
  RandomStream random(6, "null");
  CampaignResults a = ExampleCampaign();
  a.identity.table.rows.resize(60), a.results.resize(60);
  a.identity.plan = "scenario: landing\n";
  a.identity.scenario = "criteria:\n";
  std::vector<std::string> metrics;
  for (int i = 0; i < 8; ++i) {
    metrics.push_back(fmt::format("error_{}_m", i));
    a.identity.scenario += fmt::format("  {}: {{max: 1}}\n", metrics.back());
  }
  CampaignResults b = a;
  int of_success = 0, of_metrics = 0;
  for (int i = 0; i < simulations; ++i) {
    for (auto* results : {&a.results, &b.results})
      for (RunResult& run : *results) {
        run.status = random.Uniform(0, 1) < 0.8 ? RunStatus::kPassed : RunStatus::kFailed;
        for (const std::string& metric : metrics) run.metrics[metric] = std::exp(random.Normal());
      }
    const Comparison c = Compare(a, b, {}, 1, 10);
    ASSERT_EQ(c.metrics.size(), 8u);
    of_success += c.success_verdict != Verdict::kNotShown;
    of_metrics += std::any_of(c.metrics.begin(), c.metrics.end(),
                              [](const MetricComparison& m) { return m.verdict != Verdict::kNotShown; });
  }
  EXPECT_LE(of_success, (0.05 + Chance(simulations)) * simulations);
  EXPECT_LE(of_metrics, (0.05 + Chance(simulations)) * simulations);
}

TEST(Compare, ComparesOnlyRowsAndMetricsThatBothHave) {
  const CampaignResults a = ExampleCampaign();
  CampaignResults b = a;
  b.results.erase(b.results.begin(), b.results.begin() + 10);
  std::int64_t lost = 0;
  for (RunResult& run : b.results)
    if (run.row < 30) lost += static_cast<std::int64_t>(run.metrics.erase("fix_share"));
  const Comparison c = Compare(a, b, {"fix_share"}, 1, kResamples);
  EXPECT_EQ(c.rows_only_a, 10);
  EXPECT_EQ(c.rows_only_b, 0);
  EXPECT_EQ(c.ends.rows(), 290);
  ASSERT_EQ(c.metrics.size(), 1u);
  EXPECT_EQ(c.metrics[0].only_a, lost);
  EXPECT_THAT(ToText(c), HasSubstr("rows have it in A alone, 0 in B alone: not compared"));
}

TEST(Compare, RefusesOtherTablesWithTheReason) {
  const CampaignResults a = ExampleCampaign();
  const auto refusal = [&](auto&& change) {
    CampaignResults b = a;
    change(b);
    try {
      Compare(a, b, {}, 1, kResamples);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal([](CampaignResults& b) { b.identity.table.rows[17][2] = "omni"; }),
              HasSubstr("row 17 has camera = pinhole in A and omni in B (1 rows differ)"));
  EXPECT_THAT(refusal([](CampaignResults& b) { b.identity.table.keys[1] = "wind.from_deg"; }),
              testing::AllOf(HasSubstr("wind.mean_m_s: varies in A and not in B"),
                             HasSubstr("wind.from_deg: varies in B and not in A")));
  EXPECT_THAT(refusal([](CampaignResults& b) { b.identity.table.rows.pop_back(); }),
              HasSubstr("A has 300 rows and B 299"));
  EXPECT_THAT(refusal([](CampaignResults& b) { b.results.clear(); }), HasSubstr("no row of which both"));
  EXPECT_EQ(refusal([](CampaignResults&) {}), "");
  EXPECT_THROW(Compare(a, a, {"no_such_metric"}, 1, kResamples), InputError);
}

TEST(Compare, ItsJsonSaysTheSame) {
  const CampaignResults a = ExampleCampaign();
  const Comparison c = Compare(a, WithGain(a, 0.8), {}, 1, kResamples);
  const auto json = nlohmann::json::parse(ToJson(c));
  EXPECT_EQ(json.at("verdict"), "better");
  EXPECT_EQ(json.at("sentence"), c.sentence);
  EXPECT_EQ(json.at("success").at("mcnemar_p"), c.chance);
  EXPECT_EQ(json.at("metrics").at(0).at("median").at("high"), c.metrics[0].differences.median.interval.high);
  EXPECT_EQ(json.at("differs").at(0), c.differs[0]);
}

}  // namespace
}  // namespace kestrel::campaign
