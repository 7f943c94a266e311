// SPDX-License-Identifier: Apache-2.0
#include "app/run/run_report.h"

#include <gmock/gmock.h>

#include <limits>

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

records::Summary Ended(std::vector<records::Criterion> criteria, bool passed) {
  records::Summary s;
  s.scenario = "landing", s.seed = 3, s.outcome = "completed";
  s.criteria = std::move(criteria);
  s.complete = true, s.passed = passed;
  return s;
}

const records::Criterion kKept{"rest_error_m", 0.1, 0.15, false, true};
const records::Criterion kMissed{"touchdown_error_m", 0.3, 0.12, false, false};
const records::Criterion kNever{"settle_s", std::numeric_limits<double>::quiet_NaN(), 15, false, false};

TEST(RunReport, TheVerdictSaysPassedOrFailedAndWhy) {
  EXPECT_EQ(Verdict(Ended({kKept}, true), false), "landing, seed 3: PASSED (completed)\n");
  EXPECT_EQ(Verdict(Ended({kKept, kMissed, kNever}, false), false),
            "landing, seed 3: FAILED: 2 of 3 criteria not met (completed)\n");
  EXPECT_EQ(Verdict(Ended({kKept}, false), false),
            "landing, seed 3: FAILED: the flight ended before what it is for was done (completed)\n");
  records::Summary broken = Ended({kKept}, false);
  broken.complete = false, broken.error = "the disk is full";
  EXPECT_EQ(Verdict(broken, false), "landing, seed 3: BROKE OFF: the disk is full\n");
}

TEST(RunReport, AllCriteriaAreInItAndOfAQuietRunThoseThatAreMissed) {
  const records::Summary s = Ended({kKept, kMissed, kNever}, false);
  EXPECT_THAT(RunReport(s, "results/x", false),
              AllOf(StartsWith("landing, seed 3: FAILED"), HasSubstr("ok   rest_error_m"),
                    HasSubstr("NOT  touchdown_error_m"), HasSubstr("not reached"), HasSubstr("results/x")));
  EXPECT_THAT(MissedCriteria(s, false), AllOf(HasSubstr("touchdown_error_m"), HasSubstr("at most 0.12"),
                                              Not(HasSubstr("rest_error_m"))));
}

TEST(RunReport, AMosaicThatIsChainedAloneStandsBesideTheOneThatIsJudged) {
  records::Summary s = Ended({{"mosaic_rms_px", 0.4, 1, false, true}}, true);
  EXPECT_THAT(RunReport(s, "x", false), Not(HasSubstr("to compare")));
  s.metrics = {{"mosaic_rms_px", 0.4}, {"chain_rms_px", 2.6}};
  const std::string report = RunReport(s, "x", false);
  EXPECT_THAT(report, HasSubstr("chain_rms_px                       2.6   to compare\n"));
  EXPECT_EQ(report.find("mosaic_rms_px"), report.rfind("mosaic_rms_px"));
}

TEST(RunReport, ColoursAreThereWhereTheyAreWanted) {
  const records::Summary s = Ended({kKept, kMissed}, false);
  EXPECT_THAT(RunReport(s, "x", true), AllOf(HasSubstr("\x1b[31mFAILED"), HasSubstr("\x1b[32mok")));
  EXPECT_THAT(RunReport(s, "x", false), Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace kestrel::app
