// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/thresholds.h"

#include <gmock/gmock.h>

#include <cmath>
#include <pugixml.hpp>

#include "campaign/statistics/share_sequence.h"

namespace kestrel::campaign {
namespace {

// So many runs with errors of 1 to `runs` mm, of which the first do not pass, and the last have no error.
std::vector<RunResult> Runs(int runs, int failed, int without) {
  std::vector<RunResult> results;
  for (int i = 0; i < runs; ++i) {
    RunResult& run = results.emplace_back();
    run.row = i;
    run.status = i < failed ? RunStatus::kFailed : RunStatus::kPassed;
    if (i < runs - without) run.metrics["error_m"] = 1e-3 * (i + 1);
  }
  return results;
}

constexpr std::optional<double> kNone;

TEST(Thresholds, AreHeldAgainstTheEndOfTheIntervalThatIsAgainstThem) {
  const auto results = Runs(1000, 3, 0);
  const Interval success = ShareInterval(997, 1000);
  const auto judged = Judge({{"success", {kNone, kNone, success.low - 1e-6}},
                             {"error_m", {0.5, 0.532, 0.469}}},  // ranks 469 and 532 of 1000: tables
                            results);
  ASSERT_EQ(judged.size(), 3u);
  EXPECT_EQ(judged[0].name, "error_m, 50 % quantile");
  EXPECT_DOUBLE_EQ(judged[0].bound, 0.532);
  EXPECT_FALSE(judged[0].at_least);
  EXPECT_DOUBLE_EQ(judged[1].bound, 0.469);
  EXPECT_TRUE(judged[1].at_least);
  EXPECT_TRUE(judged[0].passed && judged[1].passed && judged[2].passed);
  EXPECT_EQ(judged[2].bound, success.low);
  // The values themselves keep to these, the intervals do not.
  for (const JudgedThreshold& t :
       Judge({{"success", {kNone, kNone, success.low + 1e-6}}, {"error_m", {0.5, 0.531, 0.47}}}, results)) {
    EXPECT_FALSE(t.passed) << t.name;
    EXPECT_TRUE(t.at_least ? t.estimate.value > t.limit : t.estimate.value < t.limit);
  }
}

TEST(Thresholds, FewRunsPassNoneThatManyWould) {
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.95}}}, Runs(71, 0, 0))[0].passed);
  EXPECT_TRUE(Judge({{"success", {kNone, kNone, 0.95}}}, Runs(72, 0, 0))[0].passed);
  EXPECT_FALSE(Judge({{"error_m", {0.95, 1.0, kNone}}}, Runs(71, 0, 0))[0].passed);
  EXPECT_TRUE(Judge({{"error_m", {0.95, 1.0, kNone}}}, Runs(72, 0, 0))[0].passed);
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.0001}}}, {})[0].passed);
}

// By the definition: one run less would not have told.
TEST(Thresholds, WhereRunsAreTooFewTheyTellHowManyWouldDo) {
  const auto all = Judge({{"success", {kNone, kNone, 0.98}}}, Runs(10, 0, 0))[0];
  ASSERT_TRUE(all.runs_to_tell);
  EXPECT_EQ(*all.runs_to_tell, std::ceil(std::log(0.025) / std::log(0.98)));  // 0.98^n = 0.025
  EXPECT_TRUE(Judge({{"success", {kNone, kNone, 0.98}}}, Runs(183, 0, 0))[0].passed);
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.98}}}, Runs(182, 0, 0))[0].passed);

  const auto most = Judge({{"success", {kNone, kNone, 0.8}}}, Runs(20, 2, 0))[0];  // 90 % passed
  ASSERT_TRUE(most.runs_to_tell);
  const std::int64_t n = *most.runs_to_tell;
  EXPECT_GE(ShareInterval(n * 9 / 10, n).low, 0.8);
  EXPECT_LT(ShareInterval((n - 1) * 9 / 10, n - 1).low, 0.8);

  const auto quantile = Judge({{"error_m", {0.95, 1.0, kNone}}}, Runs(20, 0, 0))[0];
  EXPECT_EQ(quantile.runs_to_tell, 72);
  // What is not kept to by the runs themselves more of them would not cure.
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.95}}}, Runs(20, 2, 0))[0].runs_to_tell);
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 1.0}}}, Runs(20, 0, 0))[0].runs_to_tell);
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.5}}}, Runs(20, 0, 0))[0].runs_to_tell);
  EXPECT_FALSE(Judge({{"success", {kNone, kNone, 0.5}}}, {})[0].runs_to_tell);
  EXPECT_THAT(ToJunit("c", {all}), testing::HasSubstr("183 would do that came out alike"));
}

TEST(Thresholds, ACampaignThatAsksNothingOfItsSuccessAsksForOneRunThatPassed) {
  const auto none = Judge({}, Runs(20, 20, 0));
  ASSERT_EQ(none.size(), 1u);
  EXPECT_EQ(none[0].name, "runs that passed");
  EXPECT_FALSE(none[0].passed);
  EXPECT_THAT(ToJunit("c", none), testing::HasSubstr("failures=\"1\""));
  EXPECT_FALSE(Judge({}, {})[0].passed);
  EXPECT_TRUE(Judge({}, Runs(20, 19, 0))[0].passed);
  // A threshold on something else says nothing of it.
  const auto other = Judge({{"error_m", {0.5, 1.0, kNone}}}, Runs(20, 20, 0));
  ASSERT_EQ(other.size(), 2u);
  EXPECT_TRUE(other[0].passed);
  EXPECT_FALSE(other[1].passed);
  // Whoever wants none says so.
  const auto any = Judge({{"success", {kNone, kNone, 0.0}}}, Runs(20, 20, 0));
  ASSERT_EQ(any.size(), 1u);
  EXPECT_TRUE(any[0].passed);
}

TEST(Thresholds, ARunWithoutTheMetricIsWorseThanAnyWithIt) {
  const auto all = Judge({{"error_m", {0.9, 1.0, kNone}}}, Runs(500, 0, 0))[0];
  const auto lost = Judge({{"error_m", {0.9, 1.0, kNone}}}, Runs(500, 0, 20))[0];
  EXPECT_EQ(lost.bound, all.bound);  // the lost ones stand above it either way
  EXPECT_EQ(lost.without, 20);
  EXPECT_FALSE(Judge({{"error_m", {0.9, 1.0, kNone}}}, Runs(500, 0, 60))[0].passed);
  EXPECT_TRUE(Judge({{"error_m", {kNone, 1.0, kNone}}}, Runs(500, 0, 0))[0].passed);
  EXPECT_FALSE(Judge({{"error_m", {kNone, 1.0, kNone}}}, Runs(500, 0, 1))[0].passed);
  EXPECT_FALSE(Judge({{"error_m", {kNone, kNone, 0.0}}}, Runs(500, 0, 1))[0].passed);
  EXPECT_FALSE(Judge({{"misspelt", {0.5, 1.0, kNone}}}, Runs(500, 0, 0))[0].passed);
}

TEST(Thresholds, ACampaignThatEndedByItsResultsIsJudgedByAnIntervalThatHoldsThen) {
  const auto results = Runs(100, 2, 0);
  const Interval fixed = ShareInterval(98, 100), sequence = ShareSequence(98, 100);
  ASSERT_LT(sequence.low, fixed.low);
  const double between = (sequence.low + fixed.low) / 2;
  EXPECT_TRUE(Judge({{"success", {kNone, kNone, between}}}, results)[0].passed);
  const auto judged = Judge({{"success", {kNone, kNone, between}}}, results, true);
  EXPECT_FALSE(judged[0].passed);
  EXPECT_EQ(judged[0].estimate.interval, sequence);
  EXPECT_THAT(ToJunit("c", judged), testing::HasSubstr("which holds however often one looks"));
}

TEST(Thresholds, OneRunIsOneAndWhatIsNotKnownIsNotANumber) {
  const auto one = ToJunit("c", Judge({{"error_m", {kNone, 1e-4, kNone}}}, Runs(1, 0, 0)));
  EXPECT_THAT(one,
              testing::AllOf(testing::HasSubstr("over 1 run;"), testing::Not(testing::HasSubstr("inf"))));
  const auto without = ToJunit("c", Judge({{"error_m", {kNone, 1.0, kNone}}}, Runs(9, 0, 1)));
  EXPECT_THAT(without, testing::AllOf(testing::HasSubstr("not known, over 9 runs"),
                                      testing::HasSubstr("1 run without it counts as worse"),
                                      testing::Not(testing::HasSubstr("inf"))));
}

TEST(Thresholds, AreCasesOfJunit) {
  const auto judged =
      Judge({{"success", {kNone, kNone, 0.9}}, {"error_m", {0.95, 0.4, kNone}}}, Runs(500, 2, 3));
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(ToJunit("dispersion", judged).c_str()));
  const auto suite = document.child("testsuites").child("testsuite");
  EXPECT_STREQ(suite.attribute("name").value(), "dispersion");
  EXPECT_EQ(suite.attribute("tests").as_int(), 2);
  EXPECT_EQ(suite.attribute("failures").as_int(), 1);
  const auto bad = suite.find_child_by_attribute("testcase", "name", "error_m, 95 % quantile");
  EXPECT_THAT(bad.child("failure").attribute("message").value(),
              testing::AllOf(testing::HasSubstr("must be at most 0.4"), testing::HasSubstr("over 500 runs"),
                             testing::HasSubstr("3 runs without it count as worse")));
  EXPECT_FALSE(suite.find_child_by_attribute("testcase", "name", "success").child("failure"));
}

}  // namespace
}  // namespace kestrel::campaign
