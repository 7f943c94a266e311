// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/flight_cost.h"

#include <gtest/gtest.h>

#include <limits>

namespace kestrel::campaign {
namespace {

FlightCost Cost() {
  FlightCost cost;
  cost.terms["error_m"] = {2, 0.1, 0.5, {}};
  cost.terms["settle_s"] = {1, 10, {}, {}};
  cost.constraints["tilt_deg"] = {8, {}, 5};
  cost.constraints["closest_m"] = {{}, 2, 4};
  cost.failure = 3;
  return cost;
}

RunResult Result(RunStatus status, double error_m, double settle_s, double tilt_deg, double closest_m) {
  RunResult result;
  result.status = status;
  result.metrics = {
      {"error_m", error_m}, {"settle_s", settle_s}, {"tilt_deg", tilt_deg}, {"closest_m", closest_m}};
  return result;
}

TEST(FlightCost, ItIsTheWeightedMetricsInTheirScales) {
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 0.05, 5, 8, 2), Cost()), 2 * 0.5 + 0.5);
}

TEST(FlightCost, AMetricCountsNoMoreThanItsWorst) {
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 7, 5, 0, 9), Cost()), 2 * 5 + 0.5);
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 0, 1e6, 0, 9), Cost()), 10);
}

TEST(FlightCost, OfAMetricThatShouldBeMuchWhatItLacksCounts) {
  FlightCost cost;
  cost.terms["closest_m"] = {2, 0.5, 3, 4};
  const auto of = [&](double closest_m) {
    return CostOf(Result(RunStatus::kPassed, 0, 0, 0, closest_m), cost);
  };
  EXPECT_DOUBLE_EQ(of(3.5), 2);
  EXPECT_DOUBLE_EQ(of(4), 0);
  EXPECT_DOUBLE_EQ(of(9), 0);
  EXPECT_DOUBLE_EQ(of(0.2), 12);  // no more than its worst, which is of what it lacks
  EXPECT_DOUBLE_EQ(CostOf(RunResult{}, cost), 12);
}

TEST(FlightCost, AConstraintThatIsBrokenCostsMoreTheMoreItIs) {
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 0, 0, 10, 9), Cost()), 5 * 1.25);
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 0, 0, 80, 9), Cost()), 5 * 2);
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kPassed, 0, 0, 0, 1.5), Cost()), 4 * 1.25);
}

TEST(FlightCost, AConstraintIsKeptByWhatHasTheMetricWithinItsLimits) {
  const CostConstraint constraint{8, {}, 5};
  EXPECT_TRUE(Keeps(Result(RunStatus::kFailed, 0, 0, 8, 0), "tilt_deg", constraint));
  EXPECT_FALSE(Keeps(Result(RunStatus::kPassed, 0, 0, 8.1, 0), "tilt_deg", constraint));
  EXPECT_FALSE(Keeps(Result(RunStatus::kPassed, 0, 0, 0, 1), "closest_m", {{}, 2, 4}));
  EXPECT_FALSE(Keeps(Result(RunStatus::kPassed, 0, 0, 0, 0), "another", constraint));
  EXPECT_FALSE(Keeps(Result(RunStatus::kCrashed, 0, 0, 0, 0), "tilt_deg", constraint));
}

TEST(FlightCost, AFlightThatDidNotPassCostsThatToo) {
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kFailed, 0, 0, 0, 9), Cost()), 3);
}

TEST(FlightCost, NoFlightCostsMoreThanOneThatWasNotFlownToItsEnd) {
  const double most = 3 + 2 * 5 + 10 + 2 * 5 + 2 * 4;
  EXPECT_DOUBLE_EQ(CostOf(RunResult{}, Cost()), most);
  for (const RunStatus status :
       {RunStatus::kBrokeOff, RunStatus::kRefused, RunStatus::kCrashed, RunStatus::kTimedOut})
    EXPECT_DOUBLE_EQ(CostOf(Result(status, 0, 0, 0, 9), Cost()), most);
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kFailed, 1e9, 1e9, 1e9, -1e9), Cost()), most);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(CostOf(Result(RunStatus::kFailed, nan, nan, nan, nan), Cost()), most);
}

}  // namespace
}  // namespace kestrel::campaign
