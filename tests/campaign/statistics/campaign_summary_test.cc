// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/campaign_summary.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/statistics.h"
#include "campaign/statistics/share_sequence.h"
#include "campaign/statistics/stop_rule.h"
#include "tests/campaign/example_campaign.h"

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(MetricAims, AreThoseOfThePlanAndTheDirectionsOfTheCriteria) {
  CampaignIdentity identity = ExampleCampaign().identity;
  MetricAims aims = AimsOf(identity);
  EXPECT_THAT(aims.listed, ElementsAre("touchdown_error_m", "fix_share"));
  EXPECT_EQ(aims.better.at("touchdown_error_m"), Better::kLower);
  EXPECT_EQ(aims.better.at("fix_share"), Better::kHigher);
  EXPECT_FALSE(aims.better.contains("height_m"));  // neither too low nor too high
  identity.plan = "scenario: landing\nthresholds: {settle_s: {quantile: 0.9, max: 12}}\n";
  aims = AimsOf(identity);
  EXPECT_THAT(aims.listed, ElementsAre("touchdown_error_m", "fix_share", "height_m"));
  EXPECT_EQ(aims.better.at("settle_s"), Better::kLower);
}

TEST(CampaignSummary, HasEverythingOfTheRuns) {
  const CampaignResults campaign = ExampleCampaign();
  const CampaignSummary s = Summarise(campaign.identity, campaign.results);
  EXPECT_EQ(s.rows, 300);
  EXPECT_EQ(s.runs, 300);
  std::vector<double> errors;
  std::set<std::int64_t> failed;
  for (const RunResult& run : campaign.results) {
    if (run.metrics.contains("touchdown_error_m")) errors.push_back(run.metrics.at("touchdown_error_m"));
    if (run.status != RunStatus::kPassed) failed.insert(run.row);
  }
  EXPECT_EQ(s.passed, 300 - std::ssize(failed));
  EXPECT_EQ(s.success.interval, ShareInterval(s.passed, 300));
  EXPECT_EQ(s.success_at_least, ShareAtLeast(s.passed, 300));

  ASSERT_EQ(s.metrics.size(), 3u);  // the listed ones first
  EXPECT_EQ(s.metrics[0].name, "touchdown_error_m");
  EXPECT_EQ(s.metrics[2].name, "max_tilt_deg");
  EXPECT_FALSE(s.metrics[2].listed);
  EXPECT_EQ(s.metrics[0].runs, std::ssize(errors));
  EXPECT_EQ(s.metrics[0].mean.value, Mean(errors));
  EXPECT_EQ(s.metrics[0].quantiles.at(0.95).value, Quantile(errors, 0.95));
  EXPECT_EQ(s.metrics[0].max, Largest(errors));

  std::set<std::int64_t> grouped;
  ASSERT_EQ(s.failures.size(), 2u);
  EXPECT_GE(s.failures[0].rows.size(), s.failures[1].rows.size());
  for (const FailureGroup& group : s.failures) grouped.insert(group.rows.begin(), group.rows.end());
  EXPECT_EQ(grouped, failed);

  EXPECT_EQ(s.effects.size(), 8u);  // two keys on success and three metrics
  ASSERT_EQ(s.worst.size(), 2u);
  EXPECT_EQ(s.worst[0].runs[0].value, Largest(errors));
  EXPECT_EQ(s.worst[0].runs[0].command,
            fmt::format("kestrel campaign replay dispersion {}", s.worst[0].runs[0].row));
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_LE(s.worst[0].runs[i].value, s.worst[0].runs[i - 1].value);
    EXPECT_GE(s.worst[1].runs[i].value, s.worst[1].runs[i - 1].value);  // of a share the least is worst
  }
}

TEST(CampaignSummary, ItsJsonHasTheDocumentedShape) {
  CampaignResults campaign = ExampleCampaign();
  campaign.results.resize(40);  // too few for an upper bound of the 95 % quantile
  const CampaignSummary s =
      Summarise(campaign.identity, campaign.results,
                std::map<std::string, Threshold>{{"success", {std::nullopt, std::nullopt, 0.5}}});
  const auto json = nlohmann::json::parse(ToJson(s));
  EXPECT_EQ(json.at("name"), "dispersion");
  EXPECT_EQ(json.at("table_hash"), HashOf(campaign.identity.table));
  EXPECT_EQ(json.at("rows"), 300);
  EXPECT_EQ(json.at("runs"), 40);
  EXPECT_EQ(json.at("success").at("low"), s.success.interval.low);
  EXPECT_EQ(json.at("success").at("at_least"), s.success_at_least);
  const auto& metric = json.at("metrics").at(0);
  EXPECT_EQ(metric.at("name"), "touchdown_error_m");
  EXPECT_EQ(metric.at("better"), "lower");
  EXPECT_EQ(metric.at("mean").at("high"), s.metrics[0].mean.interval.high);
  EXPECT_EQ(metric.at("quantiles").at(2).at("q"), 0.95);
  EXPECT_EQ(metric.at("quantiles").at(2).at("value"), s.metrics[0].quantiles.at(0.95).value);
  EXPECT_TRUE(metric.at("quantiles").at(2).at("high").is_null());
  EXPECT_TRUE(json.at("metrics").at(2).at("better").is_null());
  EXPECT_EQ(json.at("failures").size(), s.failures.size());
  for (const auto& effect : json.at("effects")) {
    EXPECT_EQ(effect.at("rank_correlation").is_null(), !effect.at("numeric").get<bool>());
    for (const char* key : {"key", "of", "runs", "first_order"}) EXPECT_TRUE(effect.contains(key)) << key;
  }
  EXPECT_EQ(json.at("worst").at(0).at("runs").at(0).at("row"), s.worst[0].runs[0].row);
  EXPECT_EQ(json.at("thresholds").at(0).at("name"), "success");
  EXPECT_EQ(json.at("thresholds").at(0).at("bound"), s.success.interval.low);
}

TEST(StopRule, IsReadFromWhereWorkOfWritesIt) {
  CampaignIdentity identity;
  identity.plan = "scenario: hover\n";
  EXPECT_EQ(StopRuleOf(identity), std::nullopt);
  identity.plan += fmt::format("\n# --set runs=3\n\n# {}\n", StopRule(0.025));
  EXPECT_EQ(StopRuleOf(identity), 0.025);
  EXPECT_EQ(StopRuleOf({}), std::nullopt);
}

// The interval of a fixed number of runs is too narrow where the runs themselves chose it.
TEST(CampaignSummary, OneThatEndedEarlyHasTheIntervalThatHoldsThen) {
  CampaignResults campaign = ExampleCampaign();
  campaign.results.resize(200);
  const auto summary = [&](const char* rule) {
    CampaignIdentity identity = campaign.identity;
    identity.plan += rule;
    return Summarise(identity, campaign.results,
                     std::map<std::string, Threshold>{{"success", {std::nullopt, std::nullopt, 0.5}}});
  };
  const CampaignSummary fixed = summary(""), early = summary("\n# --stop-when 0.1\n"),
                        going = summary("\n# --stop-when 0.001\n");
  EXPECT_EQ(early.success.interval, ShareSequence(early.passed, 200));
  EXPECT_LT(early.success.interval.low, fixed.success.interval.low);
  EXPECT_EQ(early.success_at_least, early.success.interval.low);
  EXPECT_EQ(early.thresholds[0].bound, early.success.interval.low);
  EXPECT_EQ(going.success.interval, early.success.interval);
  EXPECT_TRUE(early.ended_early && !going.ended_early && !fixed.ended_early);
  EXPECT_THAT(ToText(early), testing::AllOf(HasSubstr("ended early after 200 of 300 runs"),
                                            HasSubstr("however often one looks")));
  EXPECT_THAT(ToText(going), Not(HasSubstr("ended early")));
  EXPECT_THAT(ToText(fixed), Not(HasSubstr("looks")));
  const auto json = nlohmann::json::parse(ToJson(early));
  EXPECT_EQ(json.at("stop_when"), 0.1);
  EXPECT_EQ(json.at("ended_early"), true);
  EXPECT_EQ(json.at("success").at("low"), early.success.interval.low);
  EXPECT_TRUE(nlohmann::json::parse(ToJson(fixed)).at("stop_when").is_null());
}

// Which of the rows beyond one that is missing there are may depend on what they came to.
TEST(CampaignSummary, WithARuleItCountsTheRowsBeforeTheFirstThatIsMissing) {
  CampaignResults campaign = ExampleCampaign();
  campaign.results.erase(campaign.results.begin() + 40);
  EXPECT_EQ(Summarise(campaign.identity, campaign.results).runs, 299);
  campaign.identity.plan += "\n# --stop-when 0.1\n";
  EXPECT_EQ(Summarise(campaign.identity, campaign.results).runs, 40);
}

TEST(CampaignSummary, ItsTextHasTheTables) {
  const CampaignResults campaign = ExampleCampaign();
  const std::string text =
      ToText(Summarise(campaign.identity, campaign.results,
                       std::map<std::string, Threshold>{{"success", {std::nullopt, std::nullopt, 0.99}}}));
  for (const char* part :
       {"dispersion: 300 of 300 runs", "95 % interval", "| touchdown_error_m ", "timed out", "target lost",
        "| wind.mean_m_s ", "Worst touchdown_error_m:", "kestrel campaign replay ", "NOT  success"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(CampaignSummary, ALongOutcomeIsCutToALine) {
  CampaignResults campaign = ExampleCampaign();
  campaign.results.resize(1);
  campaign.results[0].status = RunStatus::kRefused;
  campaign.results[0].outcome = "scenario.yaml:3: wind: too much\nscenario.yaml:4: more";
  const std::string text = ToText(Summarise(campaign.identity, campaign.results));
  EXPECT_THAT(text, HasSubstr("| scenario.yaml:3: wind: too much... "));
  EXPECT_THAT(text, testing::Not(HasSubstr("yaml:4")));
}

TEST(CampaignSummary, OneRunIsOne) {
  CampaignResults campaign = ExampleCampaign();
  campaign.results.resize(1);
  campaign.identity.table.rows.resize(1);
  EXPECT_THAT(ToText(Summarise(campaign.identity, campaign.results)), HasSubstr("1 of 1 run\n"));
}

TEST(CampaignSummary, OfNoRunsIsOne) {
  CampaignResults campaign = ExampleCampaign();
  const CampaignSummary s = Summarise(campaign.identity, {}, {}, "kestrel campaign replay elsewhere.yaml");
  EXPECT_THAT(ToText(s), HasSubstr("0 of 300 runs"));
  const auto json = nlohmann::json::parse(ToJson(s));
  EXPECT_TRUE(json.at("success").at("value").is_null());
  EXPECT_EQ(json.at("success").at("low"), 0);
  EXPECT_EQ(json.at("metrics").size(), 0u);
}

}  // namespace
}  // namespace kestrel::campaign
