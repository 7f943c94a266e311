// SPDX-License-Identifier: Apache-2.0
#include "records/plot/flown_plot.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "control/safety/safety.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::records {
namespace {

using FlownPlotTest = InTemporaryFolder;

int Count(const cv::Mat& picture, const cv::Vec3b& bgr) {
  int count = 0;
  for (const cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(picture)) count += cv::norm(pixel, bgr) < 12;
  return count;
}

// Sinks for ten seconds, seen all the while; the safety layer holds it in the last four.
std::vector<LogRow> Sinking() {
  std::vector<LogRow> rows;
  for (int i = 0; i <= 200; ++i) {
    LogRow row;
    row.now.t_s = row.exposure.t_s = i / 20.0;
    const bool held = row.now.t_s > 6;
    row.estimate.p_NB = {0, 0, -5 + 0.3 * row.now.t_s};
    row.decision.phase = "descend";
    row.decision.fix = mission::TargetFix{{0.3, -0.2, -5 + 0.3 * row.now.t_s}, 0, 30, 0.5, 1, true};
    row.decision.setpoint = control::VelocitySetpoint{{0.1, 0, 0.3}, 0};
    row.sent = control::VelocitySetpoint{held ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.1, 0, 0.3), 0};
    row.hazard = held ? "stale image" : "none";
    row.reaction = control::NameOf(held ? control::Reaction::kHold : control::Reaction::kFly);
    rows.push_back(row);
  }
  return rows;
}

TEST_F(FlownPlotTest, ShowsWhatWasSeenAndSentAndWhereTheSafetyLayerStoodIn) {
  DrawFlownPlot(folder_ / "flown.png", Sinking(), "LIVE, a descent");
  const cv::Mat picture = cv::imread((folder_ / "flown.png").string());
  ASSERT_EQ(picture.size(), cv::Size(1200, 1700));
  EXPECT_GT(Count(picture, {0x00, 0x9f, 0xe6}), 500);  // what was seen
  const cv::Vec3b shade(0xe3, 0xe3, 0xfb);
  EXPECT_EQ(Count(picture(cv::Rect(120, 100, 500, 800)), shade), 0);
  EXPECT_GT(Count(picture(cv::Rect(760, 100, 380, 800)), shade), 100'000);
}

TEST_F(FlownPlotTest, AnAircraftThatWasNeverHeardIsDrawnToo) {
  LogRow row;
  row.heard = false;
  DrawFlownPlot(folder_ / "flown.png", {row, row}, "nothing");
  EXPECT_FALSE(cv::imread((folder_ / "flown.png").string()).empty());
}

}  // namespace
}  // namespace kestrel::records
