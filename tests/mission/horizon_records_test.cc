// SPDX-License-Identifier: Apache-2.0
#include "mission/horizon_records.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

// Rolls and pitches are off by one degree each, once by ten; the heading gains a tenth of a degree a second
// over one and a half turns.
TEST(HorizonMetrics, AttitudesAreJudgedAtTheExposureAndHeadingsFromTheirFirst) {
  std::vector<LogRow> rows;
  for (int k = 0; k <= 20; ++k) {
    const double yaw = Radians(40 + 27 * k);
    LogRow row;
    row.exposure.t_s = row.now.t_s = k;
    row.exposure.X_NB.R = Eigen::Quaterniond(RotationFromTaitBryan({WrapAngle(yaw), 0.1, -0.2}));
    if (k >= 1) {
      AttitudeFix fix{-0.2 + Radians(1), 0.1 - Radians(k == 5 ? 10 : 1), Radians(0.6), Radians(0.6), {}, 0};
      fix.turned = yaw - Radians(40 + 27) + Radians(0.1 * (k - 1));
      const auto report = std::make_shared<HorizonReport>();
      report->attitude = fix;
      row.decision.report = report;
    }
    rows.push_back(row);
  }
  std::map<std::string, double> m;
  AddHorizonMetrics(rows, m);
  EXPECT_NEAR(m.at("roll_rmse_deg"), 1, 1e-9);
  EXPECT_NEAR(m.at("pitch_rmse_deg"), std::sqrt((19 * 1 + 100) / 20.0), 1e-9);
  EXPECT_EQ(m.at("attitude_outliers"), 1);
  EXPECT_NEAR(m.at("attitude_share"), 20 / 21.0, 1e-12);
  EXPECT_NEAR(m.at("attitude_within_2_sigma"), 39 / 40.0, 1e-12);
  double early = 0, late = 0;
  for (int k = 1; k <= 20; ++k) (k < 10 ? early : late) += std::pow(0.1 * (k - 1), 2);
  EXPECT_NEAR(m.at("yaw_rmse_deg"), std::sqrt((early + late) / 20), 1e-6);
  EXPECT_NEAR(m.at("yaw_rmse_first_half_deg"), std::sqrt(early / 9), 1e-6);
  EXPECT_NEAR(m.at("yaw_rmse_second_half_deg"), std::sqrt(late / 11), 1e-6);
  EXPECT_FALSE(m.contains("baseline_roll_rmse_deg"));
}

TEST(HorizonMetrics, AllOfThemHaveNames) {
  std::vector<LogRow> rows(25);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].exposure.t_s = 0.1 * static_cast<double>(k);
    const auto report = std::make_shared<HorizonReport>();
    report->attitude = report->baseline = AttitudeFix{0, 0, 0.01, 0.01, 0.0, 0.01};
    rows[k].decision.report = report;
  }
  std::map<std::string, double> metrics;
  AddHorizonMetrics(rows, metrics);
  std::vector<std::string> names;
  for (const auto& [name, value] : metrics) names.push_back(name);
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(NamesOf(HorizonMetrics())));
}

}  // namespace
}  // namespace kestrel::mission
