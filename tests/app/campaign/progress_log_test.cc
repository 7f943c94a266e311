// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/progress_log.h"

#include <gmock/gmock.h>

namespace kestrel::app {
namespace {

campaign::Progress At(std::int64_t done, double wall_s, std::int64_t rows = 200) {
  return {.rows = rows, .done = done, .passed = done / 2, .flown = done, .wall_s = wall_s};
}

TEST(ProgressLog, TellsOfEveryTenthOfTheRuns) {
  ProgressLog log("wind");
  EXPECT_EQ(log.Line(At(0, 0)), "");
  EXPECT_EQ(log.Line(At(19, 9)), "");
  EXPECT_EQ(log.Line(At(20, 10)), "wind: 20 of 200 runs, 10 passed, 120 runs/min, 1 min 30 s left\n");
  EXPECT_EQ(log.Line(At(21, 11)), "");
  EXPECT_EQ(log.Line(At(200, 100)), "wind: 200 of 200 runs, 100 passed, 120 runs/min, 0 s left\n");
}

TEST(ProgressLog, TellsAfterHalfAMinuteWithoutALine) {
  ProgressLog log("wind");
  EXPECT_EQ(log.Line(At(0, 0)), "");
  EXPECT_EQ(log.Line(At(1, 29)), "");
  EXPECT_THAT(log.Line(At(1, 31)), testing::StartsWith("wind: 1 of 200 runs, 0 passed, "));
  EXPECT_EQ(log.Line(At(2, 60)), "");
  EXPECT_NE(log.Line(At(2, 61)), "");
}

TEST(ProgressLog, OfWhatWasFlownBeforeItTellsNothing) {
  ProgressLog log("wind");
  campaign::Progress there = At(150, 0);
  there.flown = 0;
  EXPECT_EQ(log.Line(there), "");
  EXPECT_NE(log.Line(At(160, 1)), "");
}

}  // namespace
}  // namespace kestrel::app
