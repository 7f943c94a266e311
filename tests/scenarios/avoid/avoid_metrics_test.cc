// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/avoid_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "scenarios/avoid/avoid_report.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

records::LogRow Row(double t_s, const Vector3d& p_N, const std::vector<Vector3d>& others, double yaw = 0) {
  records::LogRow row;
  row.now.t_s = t_s;
  row.now.X_NB.p = p_N;
  for (const Vector3d& p : others) row.now.targets.push_back({.diameter_m = 1, .p_N = p});
  row.estimate.R_NB = HeadingRotation(yaw);
  row.decision.phase = "cruise";
  return row;
}

std::map<std::string, double> MetricsOf(const std::vector<records::LogRow>& rows) {
  std::map<std::string, double> m;
  AddAvoidMetrics(rows, m);
  return m;
}

TEST(AvoidMetrics, OnlyOfFlightsThatAvoidAndHaveOthers) {
  std::vector<records::LogRow> rows = {Row(0, {0, 0, -4}, {}), Row(1, {1, 0, -4}, {})};
  EXPECT_TRUE(MetricsOf(rows).empty());
  rows = {Row(0, {0, 0, -4}, {{9, 0, -4}})};
  EXPECT_FALSE(MetricsOf(rows).empty());
  rows.front().decision.phase = "follow";
  EXPECT_TRUE(MetricsOf(rows).empty());
}

TEST(AvoidMetrics, TheClosestOfTwoStraightFlightsIsFoundBetweenTheRows) {
  std::vector<records::LogRow> rows;
  // 3 m/s head-on, 1.2 m aside and 0.5 m below: nearest after 10 m / 3 m/s, at 1.3 m.
  for (int k = 0; k <= 8; ++k) rows.push_back(Row(k, {2.0 * k, 0, -4}, {{10.0 - k, 1.2, -3.5}, {0, 20, -4}}));
  const auto m = MetricsOf(rows);
  EXPECT_NEAR(m.at("closest_m"), 1.3, 1e-12);
  EXPECT_NEAR(m.at("closest_s"), 10 / 3.0, 1e-12);
  EXPECT_EQ(m.at("manoeuvred"), 0);
  EXPECT_EQ(m.count("manoeuvre_s"), 0u);
  EXPECT_EQ(m.count("closest_share"), 0u);
}

TEST(AvoidMetrics, OfSeveralOthersAndOfTheEndsTheNearestCounts) {
  std::vector<records::LogRow> rows;
  for (int k = 0; k <= 3; ++k) rows.push_back(Row(k, {1.0 * k, 0, -4}, {{10, 0, -4}, {-1, 0, -4}}));
  EXPECT_NEAR(MetricsOf(rows).at("closest_m"), 1, 1e-12);
  EXPECT_EQ(MetricsOf(rows).at("closest_s"), 0);
  rows.push_back(Row(4, {9.75, 0, -4}, {{10, 0, -4}, {-1, 0, -4}}));
  EXPECT_NEAR(MetricsOf(rows).at("closest_m"), 0.25, 1e-12);
  EXPECT_EQ(MetricsOf(rows).at("closest_s"), 4);
}

std::shared_ptr<const AvoidReport> Reported(const Encounter& encounter) {
  const auto report = std::make_shared<AvoidReport>();
  report->encounter = encounter;
  return report;
}

TEST(AvoidMetrics, TheShareIsOfWhatTheThesisBearingAllowsWhereOneWasFirstHeld) {
  std::vector<records::LogRow> rows;
  for (int k = 0; k <= 10; ++k) rows.push_back(Row(k, {2.0 * k, 0, -4}, {{14, 3, -4}}));
  rows[1].decision.report = Reported({});  // seen, and nothing to be done
  rows[5].decision.report = Reported({.wanted = Radians(-60)});
  rows[6].decision.report = Reported({.wanted = Radians(-80)});
  const auto m = MetricsOf(rows);
  EXPECT_EQ(m.at("manoeuvred"), 1);
  EXPECT_EQ(m.at("manoeuvre_s"), 5);
  EXPECT_NEAR(m.at("closest_share"), 3 / (5 * std::sin(50 * M_PI / 180)), 1e-9);  // from 5 m away
}

TEST(AvoidMetrics, TheCourseIsThatOfTheHeadingAtTheBeginning) {
  // Course north-east; it ends 5 m from where it began, on a way of 3 m and 4 m.
  std::vector<records::LogRow> rows;
  for (const Vector3d& p : {Vector3d(1, 1, -4), Vector3d(4, 1, -4.5), Vector3d(4, 5, -3.2)})
    rows.push_back(Row(static_cast<double>(rows.size()), p, {{50, 50, -4}}, Radians(45)));
  rows.back().estimate.R_NB = HeadingRotation(2);
  rows.front().estimate.p_NB = {100, 100, 0};
  rows.back().estimate.p_NB = {103, 101, 0};
  const auto m = MetricsOf(rows);
  EXPECT_NEAR(m.at("course_end_m"), (4 - 3) / std::sqrt(2), 1e-9);
  EXPECT_NEAR(m.at("course_end_own_m"), (3 - 1) / std::sqrt(2), 1e-9);
  EXPECT_NEAR(m.at("path_excess"), 7 / 5.0 - 1, 1e-12);
  EXPECT_NEAR(m.at("manoeuvre_height_m"), 0.8, 1e-12);
}

TEST(AvoidMetrics, AllOfThemHaveNames) {
  std::vector<records::LogRow> rows = {Row(0, {0, 0, -4}, {{9, 0, -4}}), Row(1, {1, 0, -4}, {{9, 0, -4}})};
  rows[1].decision.report = Reported({.wanted = 1.0});
  std::vector<std::string> names;
  for (const auto& [name, value] : MetricsOf(rows)) names.push_back(name);
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(NamesOf(AvoidMetrics())));
}

}  // namespace
}  // namespace kestrel::scenarios
