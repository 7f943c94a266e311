// SPDX-License-Identifier: Apache-2.0
#include "scenarios/pose/pose_metrics.h"

#include <gtest/gtest.h>

#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

// A pad that is turned, over which the aircraft goes north with 2 m/s, with an autopilot that believes it 0.3
// m farther along the pad's x, and turned by 3 degrees, and a camera that is right. The frame comes late.
TEST(PoseMetrics, TellTheFixLessTheAutopilotAtTheExposure) {
  constexpr double kPeriod_s = 0.05, kLatency_s = 0.07, kSpeed_m_s = 2;
  const Pose X_NT{HeadingRotation(Radians(90)), {10, -4, -0.01}};
  const auto at = [&](double t_s) { return Pose{HeadingRotation(Radians(20)), {kSpeed_m_s * t_s, 1, -4}}; };
  std::vector<records::LogRow> rows;
  for (int i = 0; i < 20; ++i) {
    records::LogRow row;
    row.exposure.t_s = i * kPeriod_s, row.now.t_s = row.exposure.t_s + kLatency_s;
    row.exposure.X_NB = at(row.exposure.t_s), row.now.X_NB = at(row.now.t_s);
    row.exposure.X_NT = row.now.X_NT = X_NT;
    row.estimate.p_NB = row.now.X_NB.p + X_NT.R * Eigen::Vector3d(0.3, 0, 0);
    row.estimate.R_NB = HeadingRotation(Radians(23));
    const Pose X_TB = X_NT.Inverse() * row.exposure.X_NB;
    if (i != 7) row.decision.fix = mission::TargetFix{.p_TB = X_TB.p, .yaw_TB = YawOf(X_TB.R)};
    rows.push_back(row);
  }
  std::map<std::string, double> metrics;
  AddPoseMetrics(rows, metrics);
  ASSERT_EQ(metrics.size(), PoseMetrics().size());
  for (const mission::Metric& metric : PoseMetrics()) EXPECT_TRUE(metrics.count(metric.name)) << metric.name;
  EXPECT_NEAR(metrics["fix_autopilot_x_rms_m"], 0.3, 1e-9);
  EXPECT_NEAR(metrics["fix_autopilot_y_rms_m"], 0, 1e-9);
  EXPECT_NEAR(metrics["fix_autopilot_z_rms_m"], 0, 1e-9);
  EXPECT_NEAR(metrics["fix_autopilot_yaw_rms_deg"], 3, 1e-9);
}

TEST(PoseMetrics, WithoutAFixThereAreNone) {
  std::map<std::string, double> metrics;
  AddPoseMetrics(std::vector<records::LogRow>(3), metrics);
  EXPECT_TRUE(metrics.empty());
}

}  // namespace
}  // namespace kestrel::scenarios
