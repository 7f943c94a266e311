// SPDX-License-Identifier: Apache-2.0
#include "records/telemetry/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/mission_type.h"

namespace kestrel::records {
namespace {

using Eigen::Vector3d;
using ::testing::UnorderedElementsAreArray;

// A pad away from the origin, turned, so that frames cannot be mixed up unseen.
const Pose kPad{HeadingRotation(Radians(90)), {100, 50, -2}};

// The truth of an aircraft at a place and attitude over the pad.
Truth Over(double t_s, const Vector3d& p_TB, const TaitBryan& angles_TB = {}) {
  Truth t;
  t.t_s = t_s;
  t.X_NT = kPad;
  t.X_NB = kPad * Pose{Eigen::Quaterniond(RotationFromTaitBryan(angles_TB)), p_TB};
  return t;
}

LogRow Row(double t_s, const Vector3d& p_TB, const TaitBryan& angles_TB = {}) {
  LogRow row;
  row.exposure = Over(t_s, p_TB, angles_TB);
  row.now = Over(t_s + 0.1, p_TB, angles_TB);
  row.estimate.landed = false;
  return row;
}

mission::TargetFix Fix(const Vector3d& p_TB, double yaw_deg) {
  mission::TargetFix fix;
  fix.p_TB = p_TB, fix.yaw_TB = Radians(yaw_deg);
  return fix;
}

TEST(Metrics, NothingFlownNothingMeasured) { EXPECT_TRUE(Metrics({}, std::nullopt, nullptr).empty()); }

TEST(Metrics, WhatDoesNotApplyIsNotThere) {
  const auto m = Metrics({Row(0, {0, 0, -4}), Row(1, {0, 0, -4})}, std::nullopt, nullptr);
  ASSERT_EQ(m.size(), 2u);
  EXPECT_EQ(m.at("fix_share"), 0);
  EXPECT_EQ(m.at("max_tilt_deg"), 0);
}

TEST(Metrics, FixesAreJudgedAtTheExposureInThePadsFrame) {
  std::vector<LogRow> rows;
  for (const double sign : {1.0, -1.0}) {
    LogRow row = Row(0, {1, -2, -4}, {Radians(179), 0, 0});
    row.decision.fix = Fix({1 + 0.3 * sign, -2, -4 - 0.4}, -178.5);  // 2.5 degrees further round
    row.now = Over(0.1, {9, 9, -9});  // where it went meanwhile does not matter
    rows.push_back(row);
  }
  rows[1].decision.fix->p_TB.y() += 0.5;
  rows.push_back(Row(1, {0, 0, -4}));
  rows.push_back(Row(2, {0, 0, -4}));
  const auto m = Metrics(rows, std::nullopt, nullptr);
  EXPECT_NEAR(m.at("fix_x_rmse_m"), 0.3, 1e-9);
  EXPECT_NEAR(m.at("fix_y_rmse_m"), 0.5 / std::sqrt(2), 1e-9);
  EXPECT_NEAR(m.at("fix_z_rmse_m"), 0.4, 1e-9);
  EXPECT_NEAR(m.at("fix_yaw_rmse_deg"), 2.5, 1e-9);
  EXPECT_NEAR(m.at("fix_share"), 0.5, 1e-12);
}

TEST(Metrics, TheLongestLossIsCountedFromTheFirstFixOnToTheEnd) {
  const auto rows_with_fixes = [](const std::vector<bool>& seen) {
    std::vector<LogRow> rows;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      rows.push_back(Row(static_cast<double>(i), {0, 0, -4}));
      if (seen[i]) rows.back().decision.fix = Fix({0, 0, -4}, 0);
    }
    return rows;
  };
  const auto loss = [&](const std::vector<bool>& seen) {
    return Metrics(rows_with_fixes(seen), std::nullopt, nullptr).at("longest_loss_s");
  };
  EXPECT_NEAR(loss({true, true, true}), 1, 1e-12);                        // from one frame to the next
  EXPECT_NEAR(loss({false, false, false, false, true, true}), 1, 1e-12);  // not before the first
  EXPECT_NEAR(loss({true, false, false, true, false, true}), 3, 1e-12);   // the longest of several
  EXPECT_NEAR(loss({true, true, false, false, false, false}), 4, 1e-12);  // one that does not end
}

// A flight towards its goal: distance from it at each second, counted from now.t_s = 0.
std::vector<LogRow> Approach(const std::vector<double>& distances_m) {
  std::vector<LogRow> rows;
  for (std::size_t i = 0; i < distances_m.size(); ++i) {
    rows.push_back(Row(static_cast<double>(i) - 0.1, {0.6 * distances_m[i], 0, -3 + 0.8 * distances_m[i]}));
    rows.back().decision.goal_T = Vector3d(0, 0, -3);
  }
  return rows;
}

TEST(Metrics, SettledIsTheFirstTimeFromWhichItStays) {
  const auto settle = [](const std::vector<double>& distances_m) {
    return Metrics(Approach(distances_m), std::nullopt, nullptr);
  };
  EXPECT_NEAR(settle({1, 0.5, 0.14, 0.1, 0.1, 0.1, 0.1}).at("settle_s"), 2, 1e-9);
  EXPECT_NEAR(settle({1, 0.1, 0.1, 0.16, 0.1, 0.1, 0.1, 0.1}).at("settle_s"), 4, 1e-9);  // it left once more
  EXPECT_NEAR(settle({0.1, 0.1, 0.1, 0.1, 2, 2}).at("settle_s"), 0, 1e-9);  // the first time counts
  EXPECT_EQ(settle({1, 0.1, 0.1, 0.1}).count("settle_s"), 0u);              // two seconds are too few
}

TEST(Metrics, TheHoldIsMeasuredFromFifteenSecondsOn) {
  std::vector<double> distances(15, 5.0);  // 0 to 14 s: not counted
  distances.resize(25);
  auto rows = Approach(distances);
  for (std::size_t i = 15; i < rows.size(); ++i) {
    const double side = i % 2 ? 1 : -1;
    rows[i].now.X_NB =
        kPad * Pose{HeadingRotation(side * Radians(176)), {side * 0.06, 0.08, -3 + side * 0.2}};
    rows[i].decision.goal_yaw_TB = -side * Radians(180);
  }
  const auto m = Metrics(rows, std::nullopt, nullptr);
  EXPECT_NEAR(m.at("hold_horizontal_rmse_m"), 0.1, 1e-9);
  EXPECT_NEAR(m.at("hold_vertical_rmse_m"), 0.2, 1e-9);
  EXPECT_NEAR(m.at("hold_yaw_rmse_deg"), 4, 1e-9);
}

TEST(Metrics, TheGreatestTiltIsTheTrueAngleFromLevel) {
  std::vector<LogRow> rows = {Row(0, {0, 0, -3}, {0.4, 0, Radians(5)}),
                              Row(1, {0, 0, -3}, {1, Radians(-9), Radians(12)}),
                              Row(2, {0, 0, -3}, {2, Radians(3), 0})};
  const double expected = Degrees(std::acos(std::cos(Radians(9)) * std::cos(Radians(12))));
  EXPECT_NEAR(Metrics(rows, std::nullopt, nullptr).at("max_tilt_deg"), expected, 1e-9);
}

TEST(Metrics, ATouchDownIsJudgedAtItsInstantAndTheRestAtTheEnd) {
  Truth touch = Over(12.5, {0.06, -0.08, -0.16}, {0.3, Radians(3), Radians(-4)});
  touch.v_N = {0.03, -0.04, 0.25};
  std::vector<LogRow> rows = {Row(12, {5, 5, -1}), Row(13, {-0.12, 0.05, -0.16}, {0, Radians(1), 0})};
  rows.back().decision.goal_T = Vector3d::Zero();
  auto m = Metrics(rows, touch, nullptr);
  EXPECT_NEAR(m.at("touchdown_s"), 12.5, 1e-12);
  EXPECT_NEAR(m.at("touchdown_error_m"), 0.1, 1e-9);
  EXPECT_NEAR(m.at("touchdown_north_m"), 0.08, 1e-9);  // left of a pad that looks east
  EXPECT_NEAR(m.at("touchdown_east_m"), 0.06, 1e-9);   // before it
  EXPECT_NEAR(m.at("touchdown_sink_m_s"), 0.25, 1e-9);
  EXPECT_NEAR(m.at("touchdown_speed_m_s"), 0.05, 1e-9);
  EXPECT_NEAR(m.at("touchdown_tilt_deg"), Degrees(std::acos(std::cos(Radians(3)) * std::cos(Radians(4)))),
              1e-9);
  EXPECT_EQ(m.count("rest_error_m"), 0u);  // it touched but did not stay

  rows.back().estimate.landed = true;
  m = Metrics(rows, touch, nullptr);
  EXPECT_NEAR(m.at("rest_error_m"), 0.13, 1e-9);
  EXPECT_NEAR(m.at("rest_tilt_deg"), 1, 1e-9);
}

TEST(Metrics, AHoldOverAFewImagesIsNone) {
  EXPECT_EQ(
      Metrics(Approach(std::vector<double>(24, 0.1)), std::nullopt, nullptr).count("hold_horizontal_rmse_m"),
      0u);
  EXPECT_EQ(
      Metrics(Approach(std::vector<double>(25, 0.1)), std::nullopt, nullptr).count("hold_horizontal_rmse_m"),
      1u);
}

TEST(Metrics, AFlightThatTouchedHeldNothing) {
  auto rows = Approach(std::vector<double>(30, 0.1));
  EXPECT_EQ(Metrics(rows, std::nullopt, nullptr).count("hold_horizontal_rmse_m"), 1u);
  EXPECT_EQ(Metrics(rows, Over(5, {0, 0, 0}), nullptr).count("hold_horizontal_rmse_m"), 0u);
}

TEST(Metrics, AFailureIsJudgedWhileItLastsAndFromWhereItBegan) {
  std::vector<LogRow> rows;
  const auto add = [&](double t_s, const TaitBryan& angles, const Vector3d& p, double believed_roll) {
    LogRow row;
    row.now.t_s = t_s;
    row.now.X_NB = {Eigen::Quaterniond(RotationFromTaitBryan(angles)), p};
    row.now.attitude_failed = t_s >= 2 && t_s < 6;
    row.estimate.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({angles.yaw + 1, 0, believed_roll}));
    row.estimate.aided = t_s >= 3 && t_s < 8;
    rows.push_back(row);
  };
  add(1, {0, 0, Radians(40)}, {9, 9, 9}, 0);  // all before and after it does not count
  add(2, {Radians(179), 0, Radians(3)}, {1, 1, -5}, Radians(1));
  add(3, {Radians(-177), 0, Radians(-4)}, {1, 4, -4.5}, Radians(-4));
  add(5, {Radians(178), 0, 0}, {-3, 1, -5.25}, Radians(-1));
  add(6, {0, 0, Radians(40)}, {9, 9, 9}, 0);
  auto m = Metrics(rows, std::nullopt, nullptr);
  EXPECT_NEAR(m.at("failure_tilt_rms_deg"), std::sqrt(25 / 3.0), 1e-9);
  EXPECT_NEAR(m.at("failure_attitude_rms_deg"), std::sqrt(5 / 3.0), 1e-9);
  EXPECT_NEAR(m.at("failure_heading_worst_deg"), 4, 1e-9);
  EXPECT_NEAR(m.at("failure_height_worst_m"), 0.5, 1e-12);
  EXPECT_NEAR(m.at("failure_place_worst_m"), 4, 1e-12);
  EXPECT_NEAR(m.at("failure_noticed_s"), 1, 1e-12);
  EXPECT_EQ(m.at("failure_returned"), 0);
  add(9, {0, 0, 0}, Vector3d::Zero(), 0);
  EXPECT_EQ(Metrics(rows, std::nullopt, nullptr).at("failure_returned"), 1);
}

TEST(Metrics, TheNamesAreThoseThatAFlightCanHave) {
  auto rows = Approach(std::vector<double>(25, 0.1));
  rows[3].decision.fix = Fix({0, 0, -3}, 0);
  rows[5].now.attitude_failed = rows[6].estimate.aided = true;
  std::vector<std::string> names;
  for (const auto& [name, value] : Metrics(rows, std::nullopt, nullptr)) names.push_back(name);
  rows.back().estimate.landed = true;
  for (const auto& [name, value] : Metrics(rows, Over(5, {0, 0, 0}), nullptr)) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  EXPECT_THAT(names, UnorderedElementsAreArray(mission::NamesOf(CommonMetrics())));
}

TEST(Metrics, OfAMissionThatDeclaresItsOwnAreThereToo) {
  const mission::MissionType type{
      .name = "some",
      .summary = "",
      .metrics = {{"rows", "1", "How many rows there are"}},
      .add_metrics = [](const std::vector<LogRow>& rows, std::map<std::string, double>& m) {
        m["rows"] = static_cast<double>(rows.size());
      }};
  EXPECT_EQ(Metrics({Row(0, {0, 0, -4}), Row(1, {0, 0, -4})}, std::nullopt, &type).at("rows"), 2);
}

}  // namespace
}  // namespace kestrel::records
