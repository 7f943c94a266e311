// SPDX-License-Identifier: Apache-2.0
// Short flights by laws of visual servoing, judged by the simulator's truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "geometry/tait_bryan.h"
#include "tests/acceptance/flown.h"

namespace kestrel {
namespace {

// The greatest distance from the goal from a time on.
double Farthest(const flight::FlightResult& result, double from_s) {
  double farthest = 0;
  int rows = 0;
  for (const records::LogRow& row : result.rows) {
    if (row.now.t_s < from_s || !row.decision.goal_T) continue;
    farthest = std::max(farthest, ((row.now.X_NT.Inverse() * row.now.X_NB).p - *row.decision.goal_T).norm());
    ++rows;
  }
  EXPECT_GT(rows, 20);
  return farthest;
}

TEST(Servo, LawsOfEachKindComeToTheirGoalAndStay) {
  for (const std::string law : {"points_mean", "hybrid", "partitioned", "level_image"}) {
    const flight::FlightResult result =
        Flown("servo", 101,
              {"flight.law=" + law, "camera=thesis_6mm_binned", "duration_s=8", "start.scatter_m=0.3",
               "start.height_m=3.6", "start.yaw_scatter_deg=30", "criteria={}"});
    EXPECT_EQ(result.summary.outcome, "completed") << law;
    EXPECT_LT(Farthest(result, 6), 0.35) << law;
  }
}

// Chaumette 1998: the image of a half turn is nearest where everything is small.
TEST(Servo, HalfATurnByPointsRetreatsAndByThePoseDoesNot) {
  const std::vector<std::string> half_turn = {
      "camera=thesis_6mm_binned", "duration_s=8",         "start={height_m: 3, yaw_deg: 180}",
      "wind.mean_m_s=0",          "flight.ceiling_m=4.5", "criteria={}"};
  std::vector<std::string> points = half_turn, pose = half_turn;
  points.push_back("flight.law=points_current"), pose.push_back("flight.law=pose");
  EXPECT_EQ(Flown("servo", 102, points).summary.outcome, "retreated");
  const flight::FlightResult turned = Flown("servo", 102, pose);
  EXPECT_EQ(turned.summary.outcome, "completed");
  const Truth& end = turned.rows.back().now;
  EXPECT_LT(std::abs(Degrees(YawOf((end.X_NT.Inverse() * end.X_NB).R))), 8);
}

TEST(HoverDirect, HoldsByRatesAndThrustAlone) {
  for (const char* scenario : {"hover_direct", "hover_photometric"}) {
    const flight::FlightResult result = Flown(scenario, 103, {"duration_s=6", "criteria={}"});
    EXPECT_LT(Farthest(result, 4), 0.25) << scenario;
    EXPECT_GT(result.summary.metrics.at("direct_share"), 0.98) << scenario;
    EXPECT_EQ(result.rows.back().estimate.mode, control::FlightMode::kRates);
  }
}

TEST(HoverDirect, WithoutAnyImageTheAutopilotHolds) {
  const flight::FlightResult result =
      Flown("hover_direct", 104,
            {"duration_s=5", "image.faults=[{type: stuck, from_s: 2, until_s: 100}]", "criteria={}"});
  EXPECT_EQ(result.rows.back().decision.phase, "search");
  EXPECT_EQ(result.rows.back().estimate.mode, control::FlightMode::kVelocity);
  EXPECT_LT(result.summary.metrics.at("direct_share"), 0.6);
}

}  // namespace
}  // namespace kestrel
