// SPDX-License-Identifier: Apache-2.0
#include "scenarios/plots.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "geometry/tait_bryan.h"
#include "tests/scenarios/temporary_folder.h"

namespace kestrel {
namespace {

class PlotsTest : public InTemporaryFolder {
 protected:
  cv::Mat Picture(const char* name) const { return cv::imread((folder_ / name).string()); }
};

const cv::Rect kTopPanel(110, 115, 1050, 265), kMiddlePanel(110, 435, 1050, 265),
    kBottomPanel(110, 755, 1050, 260);

// The mean place of the pixels near a colour within the part of a figure that spans these shares of its
// width.
cv::Point2d CentreOf(const cv::Mat& picture, cv::Rect panel, const cv::Vec3b& bgr, double from, double to) {
  cv::Point2d sum;
  int count = 0;
  const int left = panel.x + static_cast<int>(from * panel.width),
            right = panel.x + static_cast<int>(to * panel.width);
  for (int y = panel.y; y < panel.y + panel.height; ++y) {
    for (int x = left; x < right; ++x) {
      if (cv::norm(picture.at<cv::Vec3b>(y, x), bgr) < 40) sum += cv::Point2d(x, y), ++count;
    }
  }
  EXPECT_GT(count, 20) << "nothing in this colour";
  return count ? sum / count : sum;
}

const cv::Vec3b kFixColour(0x00, 0x9f, 0xe6), kX(0x00, 0x5e, 0xd5), kY(0xb2, 0x72, 0x00),
    kZ(0x73, 0x9e, 0x00), kYaw(0x55, 0x22, 0x88), kTruth(0x22, 0x22, 0x22);

// Climbs for 10 s over a pad that lies turned, away from the origin; the fix is off by a constant.
std::vector<LogRow> Climb(const Eigen::Vector3d& off_m, double yaw_off_deg) {
  std::vector<LogRow> rows;
  for (int i = 0; i <= 300; ++i) {
    LogRow row;
    row.exposure.t_s = row.now.t_s = i / 30.0;
    row.exposure.X_NT = {HeadingRotation(Radians(200)), {30, -20, 0}};
    const Pose X_TB{HeadingRotation(Radians(179)), {0.2 * row.now.t_s, -0.1 * row.now.t_s, -row.now.t_s}};
    row.exposure.X_NB = row.exposure.X_NT * X_TB;
    row.now = row.exposure;
    row.estimate.p_NB = row.now.X_NB.p;
    row.decision.phase = "climb";
    row.decision.fix = TargetFix{X_TB.p + off_m, WrapAngle(Radians(179 + yaw_off_deg)), 30, 0.5, 1, true};
    rows.push_back(row);
  }
  return rows;
}

TEST_F(PlotsTest, PositionShowsThePadsAxesAndHeightUpwards) {
  DrawPlots(folder_, Climb({0.5, 0, 0}, 0), {"a climb", {1.19, 0.91}});
  const cv::Mat picture = Picture("position.png");
  ASSERT_EQ(picture.size(), cv::Size(1200, 1100));
  const auto rise = [&](const cv::Rect& panel) {
    return CentreOf(picture, panel, kFixColour, 0, 0.3).y - CentreOf(picture, panel, kFixColour, 0.7, 1).y;
  };
  EXPECT_GT(rise(kTopPanel), 50);
  EXPECT_LT(rise(kMiddlePanel), -50);
  EXPECT_GT(rise(kBottomPanel), 50);
  EXPECT_LT(CentreOf(picture, kTopPanel, kFixColour, 0.4, 0.6).y,
            CentreOf(picture, kTopPanel, kTruth, 0.4, 0.6).y - 20);
}

TEST_F(PlotsTest, ErrorIsTheFixLessTheTruthInThePadsFrame) {
  // The yaw of the fix passes through half a turn: its error must not.
  DrawPlots(folder_, Climb({0.5, -0.5, 0.1}, 4), {});
  const cv::Mat picture = Picture("error.png");
  ASSERT_FALSE(picture.empty());
  const double x = CentreOf(picture, kTopPanel, kX, 0, 1).y, y = CentreOf(picture, kTopPanel, kY, 0, 1).y,
               z = CentreOf(picture, kTopPanel, kZ, 0, 1).y;
  EXPECT_NEAR((z - x) / (y - x), 0.4 / 1.0, 0.03);  // errors of 0.5, -0.5 and 0.1 m
  EXPECT_LT(x, y);
  EXPECT_NEAR(CentreOf(picture, kMiddlePanel, kYaw, 0, 1).y, kMiddlePanel.y + kMiddlePanel.height / 2, 25);
}

TEST_F(PlotsTest, AnAttitudeIsDrawnBesideItsErrors) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  for (LogRow& row : rows) {
    row.decision.fix.reset();
    const double t = row.exposure.t_s, roll = Radians(2 * t);
    row.exposure.X_NB.R = Eigen::Quaterniond(RotationFromTaitBryan({0, 0, roll}));
    row.decision.attitude = AttitudeFix{roll + Radians(t < 5 ? -1 : 1), 0, Radians(1), Radians(1), {}, 0};
  }
  DrawPlots(folder_, rows, {});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "error.png"));
  const cv::Mat picture = Picture("attitude.png");
  ASSERT_EQ(picture.size(), cv::Size(1600, 1000));
  const cv::Rect roll(100, 105, 690, 245), error(890, 125, 670, 225);
  EXPECT_GT(CentreOf(picture, roll, kTruth, 0, 0.3).y, CentreOf(picture, roll, kTruth, 0.7, 1).y + 50);
  EXPECT_GT(CentreOf(picture, error, kX, 0, 0.45).y, CentreOf(picture, error, kX, 0.55, 1).y + 50);
}

TEST_F(PlotsTest, WithoutRowsThereIsNothingToDraw) {
  DrawPlots(folder_, {}, {});
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(PlotsTest, ATitleRunsNothing) {
  const auto victim = folder_ / "ran";
  DrawPlots(folder_, Climb({0, 0, 0}, 0),
            {"`touch " + victim.string() + "` '.system('touch " + victim.string() + "').'", {1, 1}});
  EXPECT_FALSE(std::filesystem::exists(victim));
  EXPECT_FALSE(Picture("position.png").empty());
}

}  // namespace
}  // namespace kestrel
