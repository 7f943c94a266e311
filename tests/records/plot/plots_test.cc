// SPDX-License-Identifier: Apache-2.0
#include "records/plot/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "control/law/sphere_target.h"
#include "geometry/tait_bryan.h"
#include "mission/horizon_observer.h"
#include "records/plot/plot_parts.h"
#include "scenarios/attitude/attitude.h"
#include "scenarios/avoid/avoid.h"
#include "scenarios/follow/follow.h"
#include "scenarios/follow/follow_report.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::records {
namespace {

class PlotsTest : public InTemporaryFolder {
 protected:
  cv::Mat Picture(const char* name) const { return cv::imread((folder_ / name).string()); }
};

// Of the five panels of error.png.
const cv::Rect kErrorX(110, 110, 1050, 225), kErrorY(110, 382, 1050, 225), kErrorZ(110, 653, 1050, 225),
    kErrorYaw(110, 925, 1050, 225), kDistance(110, 1196, 1050, 225);
// Of the four panels of position.png.
const cv::Rect kPanelX(110, 122, 1050, 237), kPanelY(110, 408, 1050, 237), kPanelHeight(110, 694, 1050, 237),
    kPanelYaw(110, 980, 1050, 237);

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

const cv::Vec3b kFixColour(0x00, 0x9f, 0xe6), kLimit(0x00, 0x5e, 0xd5), kEstimate(0xb2, 0x72, 0x00),
    kSetpoint(0x73, 0x9e, 0x00), kTruth(0x22, 0x22, 0x22);

const Eigen::Vector2d kPad_m(1.19, 0.91);

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
    row.decision.fix =
        mission::TargetFix{X_TB.p + off_m, WrapAngle(Radians(179 + yaw_off_deg)), 30, 0.5, 1, true};
    rows.push_back(row);
  }
  return rows;
}

TEST_F(PlotsTest, PositionShowsThePadsAxesAndHeightUpwards) {
  DrawPlots(folder_, Climb({0.5, 0, 0}, 4), {"a climb", kPad_m});
  const cv::Mat picture = Picture("position.png");
  ASSERT_EQ(picture.size(), cv::Size(1200, 1300));
  const auto rise = [&](const cv::Rect& panel) {
    return CentreOf(picture, panel, kFixColour, 0, 0.3).y - CentreOf(picture, panel, kFixColour, 0.7, 1).y;
  };
  EXPECT_GT(rise(kPanelX), 50);
  EXPECT_LT(rise(kPanelY), -50);
  EXPECT_GT(rise(kPanelHeight), 50);
  EXPECT_LT(CentreOf(picture, kPanelX, kFixColour, 0.4, 0.6).y,
            CentreOf(picture, kPanelX, kTruth, 0.4, 0.6).y - 20);
  // Past half a turn the yaw of the fix goes on.
  EXPECT_LT(CentreOf(picture, kPanelYaw, kFixColour, 0, 1).y,
            CentreOf(picture, kPanelYaw, kTruth, 0, 1).y - 20);
}

double Rise(const cv::Mat& picture, const cv::Rect& panel, const cv::Vec3b& colour) {
  return CentreOf(picture, panel, colour, 0, 0.3).y - CentreOf(picture, panel, colour, 0.7, 1).y;
}

TEST_F(PlotsTest, ErrorIsTheFixLessTheTruthInThePadsFrame) {
  // The yaw of the fix passes through half a turn: its error must not.
  std::vector<LogRow> rows = Climb({0, 0, 0}, 4);
  for (LogRow& row : rows) row.decision.fix->p_TB += 0.1 * row.now.t_s * Eigen::Vector3d(0.5, -0.5, 0.1);
  DrawPlots(folder_, rows, {"", kPad_m});
  const cv::Mat picture = Picture("error.png");
  ASSERT_EQ(picture.size(), cv::Size(1200, 1500));
  EXPECT_GT(Rise(picture, kErrorX, kFixColour), 50);
  EXPECT_LT(Rise(picture, kErrorY, kFixColour), -50);
  EXPECT_GT(Rise(picture, kErrorZ, kFixColour), 50);
  EXPECT_NEAR(CentreOf(picture, kErrorYaw, kFixColour, 0, 1).y, kErrorYaw.y + kErrorYaw.height / 2, 25);
}

TEST_F(PlotsTest, ErrorHasTheDistanceFromThePad) {
  DrawPlots(folder_, Climb({0, 0, 0}, 0), {"", kPad_m});
  EXPECT_GT(Rise(Picture("error.png"), kDistance, kTruth), 50);
}

TEST_F(PlotsTest, PositionShowsWhereTheAircraftWasSent) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  DrawPlots(folder_, rows, {"", kPad_m});
  const auto green = [&] {
    cv::Mat is;
    cv::inRange(Picture("position.png")(kPanelX), kSetpoint, kSetpoint, is);
    return cv::countNonZero(is);
  };
  EXPECT_EQ(green(), 0);
  for (LogRow& row : rows)  // 1 m along the pad's x
    row.decision.setpoint = control::PositionSetpoint{row.now.X_NT * Eigen::Vector3d(1, 0, -5), 0};
  DrawPlots(folder_, rows, {"", kPad_m});
  EXPECT_GT(green(), 300);
  // It passes there after half of the flight.
  const cv::Mat picture = Picture("position.png");
  EXPECT_NEAR(CentreOf(picture, kPanelX, kSetpoint, 0.45, 0.55).y,
              CentreOf(picture, kPanelX, kTruth, 0.45, 0.55).y, 12);
}

PlotOptions PlotsOf(const mission::MissionType& type) {
  PlotOptions options;
  options.mission = &type;
  return options;
}

// Rows of a panel that are a line in this colour.
int LinesAcross(const cv::Mat& picture, const cv::Rect& panel, const cv::Vec3b& colour) {
  int lines = 0;
  bool within = false;
  for (int y = panel.y; y < panel.y + panel.height; ++y) {
    int count = 0;
    for (int x = panel.x; x < panel.x + panel.width; ++x)
      count += cv::norm(picture.at<cv::Vec3b>(y, x), colour) < 55;
    lines += count > panel.width / 3 && !within;
    within = count > panel.width / 3;
  }
  return lines;
}

TEST_F(PlotsTest, CriteriaAreLinesWhereTheyDoNotMakeTheDataSmall) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  for (LogRow& row : rows) row.decision.fix->p_TB += 0.01 * row.now.t_s * Eigen::Vector3d(0.5, -0.5, 0);
  PlotOptions options{"", kPad_m};
  DrawPlots(folder_, rows, options);
  for (const cv::Rect& panel : {kErrorX, kErrorY, kDistance})
    EXPECT_EQ(LinesAcross(Picture("error.png"), panel, kLimit), 0);
  options.limits = {
      {"fix_x_rmse_m", 0.04, false}, {"fix_y_rmse_m", 4, false}, {"touchdown_error_m", 1, false}};
  DrawPlots(folder_, rows, options);
  EXPECT_EQ(LinesAcross(Picture("error.png"), kErrorX, kLimit), 2);  // an error may be to either side
  EXPECT_EQ(LinesAcross(Picture("error.png"), kErrorY, kLimit), 0);
  EXPECT_EQ(LinesAcross(Picture("error.png"), kDistance, kLimit), 1);
}

TEST_F(PlotsTest, ACriterionOfAnAttitudeIsWhereItsErrorsAre) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  for (LogRow& row : rows) {
    row.decision.fix.reset();
    row.exposure.X_NB.R = Eigen::Quaterniond::Identity();
    const auto report = std::make_shared<mission::HorizonReport>();
    report->attitude = mission::AttitudeFix{Radians(2), 0, Radians(0.1), Radians(0.1), {}, 0};
    row.decision.report = report;
  }
  const mission::MissionType type = TypeOf(scenarios::AttitudeFlight{});
  PlotOptions options = PlotsOf(type);
  options.limits = {{"roll_rmse_deg", 3, false}};
  DrawPlots(folder_, rows, options);
  const cv::Mat picture = Picture("attitude.png");
  const cv::Rect error(890, 125, 670, 228);
  EXPECT_EQ(LinesAcross(picture, error, kLimit), 2);
  // All errors are 2 degrees: at five sixths of the way from one line to the other.
  const cv::Rect upper(890, 125, 670, 60), lower(890, 290, 670, 63);
  const double above = CentreOf(picture, upper, kLimit, 0, 0.5).y,
               below = CentreOf(picture, lower, kLimit, 0, 0.5).y;
  EXPECT_NEAR((below - CentreOf(picture, error, kFixColour, 0, 0.5).y) / (below - above), 5 / 6.0, 0.02);
  options.limits = {{"roll_rmse_deg", 5, false}};
  DrawPlots(folder_, rows, options);
  EXPECT_EQ(LinesAcross(Picture("attitude.png"), error, kLimit), 0);
}

TEST_F(PlotsTest, AnAttitudeIsDrawnBesideItsErrors) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  for (LogRow& row : rows) {
    row.decision.fix.reset();
    const double t = row.exposure.t_s, roll = Radians(2 * t);
    row.exposure.X_NB.R = Eigen::Quaterniond(RotationFromTaitBryan({0, 0, roll}));
    const auto report = std::make_shared<mission::HorizonReport>();
    report->attitude = mission::AttitudeFix{roll + Radians(t < 5 ? -1 : 1), 0, Radians(1), Radians(1), {}, 0};
    row.decision.report = report;
  }
  const mission::MissionType type = TypeOf(scenarios::AttitudeFlight{});
  DrawPlots(folder_, rows, PlotsOf(type));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "error.png"));
  const cv::Mat picture = Picture("attitude.png");
  ASSERT_EQ(picture.size(), cv::Size(1600, 1000));
  const cv::Rect roll(100, 125, 670, 228), error(890, 125, 670, 228);
  EXPECT_GT(CentreOf(picture, roll, kTruth, 0, 0.3).y, CentreOf(picture, roll, kTruth, 0.7, 1).y + 50);
  EXPECT_GT(CentreOf(picture, error, kFixColour, 0, 0.45).y,
            CentreOf(picture, error, kFixColour, 0.55, 1).y + 50);
}

TEST_F(PlotsTest, AnAttitudeThatFailedIsDrawnAndShaded) {
  std::vector<LogRow> rows = Climb({0, 0, 0}, 0);
  for (LogRow& row : rows) {
    const double t = row.exposure.t_s;
    row.decision.fix.reset();
    row.exposure.X_NB.R = Eigen::Quaterniond::Identity();
    row.now.attitude_failed = t > 4 && t < 6;
    row.estimate.R_NB_inertial =
        Eigen::Quaterniond(RotationFromTaitBryan({0, 0, Radians(t > 4 && t < 6 ? 3 : 0)}));
    const auto report = std::make_shared<mission::HorizonReport>();
    report->attitude = mission::AttitudeFix{0, 0, Radians(1), Radians(1), {}, 0};
    row.decision.report = report;
  }
  const mission::MissionType type = TypeOf(scenarios::AttitudeFlight{});
  DrawPlots(folder_, rows, PlotsOf(type));
  const cv::Mat picture = Picture("attitude.png");
  const cv::Rect roll(100, 125, 670, 228);
  EXPECT_LT(CentreOf(picture, roll, kEstimate, 0.45, 0.55).y,
            CentreOf(picture, roll, kTruth, 0.45, 0.55).y - 50);
  // 96 to 776 px are 10 s.
  for (const int t_s : {2, 5, 8})
    EXPECT_EQ(cv::norm(picture.at<cv::Vec3b>(340, 96 + 68 * t_s + 15), cv::Vec3b(0xe3, 0xe3, 0xfb)) < 6,
              t_s == 5)
        << t_s << " s";
}

bool Has(const std::filesystem::path& folder, const char* name) {
  return std::filesystem::exists(folder / name);
}

// The mean colour within a few pixels of a place that must be of one colour.
cv::Vec3b ColourAt(const cv::Mat& picture, cv::Point at) {
  const cv::Scalar mean = cv::mean(picture(cv::Rect(at.x - 2, at.y - 2, 5, 5)));
  return {cv::saturate_cast<uchar>(mean[0]), cv::saturate_cast<uchar>(mean[1]),
          cv::saturate_cast<uchar>(mean[2])};
}

// 10 s in which the balloon goes to the right and comes nearer in the image; lost from 4 s to 6 s.
std::vector<LogRow> Following() {
  std::vector<LogRow> rows;
  for (int i = 0; i <= 300; ++i) {
    LogRow row;
    const double t = row.exposure.t_s = row.now.t_s = i / 30.0;
    row.now.X_NB = row.exposure.X_NB = {Eigen::Quaterniond::Identity(), {0, 0, -4}};
    TargetTruth balloon;
    balloon.diameter_m = 0.5;
    balloon.p_V = {0.1 * t, 0, 5 - 0.2 * t};
    row.now.targets = {balloon};
    const bool lost = t > 4 && t < 6;
    row.decision.phase = lost ? "look around" : "follow";
    const control::SphereImage wanted{Eigen::Vector2d(0.2, 0), 0.15};
    if (!lost) {
      const auto report = std::make_shared<scenarios::FollowReport>();
      report->sight = {control::SphereImageOf(balloon.p_V, 0.5), wanted, 400};
      row.decision.report = report;
    }
    row.decision.setpoint = control::VelocitySetpoint{{1 - 0.2 * t, 0, -0.5}, Radians(10 * t - 50)};
    rows.push_back(row);
  }
  return rows;
}

TEST_F(PlotsTest, FollowingShowsTheImageBesideWhatIsWantedOfIt) {
  const mission::MissionType type = TypeOf(scenarios::FollowFlight{});
  DrawPlots(folder_, Following(), PlotsOf(type));
  EXPECT_FALSE(Has(folder_, "error.png"));  // there is no pad
  EXPECT_FALSE(Has(folder_, "encounter.png"));
  const cv::Mat picture = Picture("follow.png");
  ASSERT_EQ(picture.size(), cv::Size(1200, 1400));
  // Both grow towards what is wanted, which stands, also while nothing is followed.
  const cv::Rect left(115, 112, 900, 200), middle(115, 362, 900, 200);
  for (const cv::Rect& panel : {left, middle}) {
    EXPECT_GT(CentreOf(picture, panel, kTruth, 0, 0.3).y, CentreOf(picture, panel, kTruth, 0.7, 1).y + 20);
    EXPECT_NEAR(CentreOf(picture, panel, kSetpoint, 0, 0.3).y,
                CentreOf(picture, panel, kSetpoint, 0.45, 0.55).y, 2);
    EXPECT_LT(CentreOf(picture, panel, kSetpoint, 0, 0.3).y, CentreOf(picture, panel, kTruth, 0, 0.3).y - 20);
  }
  // 108 to 1164 px are 10 s.
  for (const int t_s : {2, 5, 8})
    EXPECT_EQ(ColourAt(picture, {108 + 1056 * t_s / 10 + 15, 120})[0] < 250, t_s == 5) << t_s << " s";
  // The velocity ahead falls, the yaw rate rises.
  EXPECT_LT(Rise(picture, {115, 612, 980, 200}, kSetpoint), -50);
  EXPECT_GT(Rise(picture, {115, 1114, 980, 200}, kSetpoint), 50);
}

// 20 s northwards at 1 m/s past a thing that stands 4 m to the right of the way, half along it; "avoid" until
// then, and "return" after.
std::vector<LogRow> Passing() {
  std::vector<LogRow> rows;
  for (int i = 0; i <= 400; ++i) {
    LogRow row;
    const double t = row.exposure.t_s = row.now.t_s = i / 20.0;
    row.now.X_NB = row.exposure.X_NB = {Eigen::Quaterniond::Identity(), {t, 0, -4}};
    TargetTruth other;
    other.p_N = {10, 4, -4};
    row.now.targets = {other};
    row.decision.phase = t < 1 ? "cruise" : t < 10 ? "avoid" : "return";
    row.decision.setpoint = control::VelocitySetpoint{{1, 0, 0}, Radians(t < 10 ? -20 : 20)};
    rows.push_back(row);
  }
  return rows;
}

TEST_F(PlotsTest, AnEncounterIsAMapWithNorthUpAndOneScale) {
  const mission::MissionType type = TypeOf(scenarios::AvoidFlight{});
  DrawPlots(folder_, Passing(), PlotsOf(type));
  EXPECT_FALSE(Has(folder_, "error.png"));
  EXPECT_FALSE(Has(folder_, "follow.png"));
  const cv::Mat picture = Picture("encounter.png");
  ASSERT_EQ(picture.rows, 1000);
  const cv::Rect map(75, 105, 320, 820);
  const cv::Vec3b other(0x55, 0x22, 0x88), avoids(0x88, 0x22, 0x33), returns(0xe9, 0xb4, 0x56);
  // The circle of 4 m about the target touches the way where its two halves meet, and is round.
  const cv::Point2d way_before = CentreOf(picture, map, avoids, 0, 1),
                    way_after = CentreOf(picture, map, returns, 0, 1);
  EXPECT_GT(way_before.y, way_after.y + 200);
  EXPECT_NEAR(way_before.x, way_after.x, 3);
  std::vector<cv::Point> circle;
  for (int y = map.y; y < map.y + map.height; ++y)
    for (int x = map.x; x < map.x + map.width; ++x)
      if (cv::norm(picture.at<cv::Vec3b>(y, x), other) < 60) circle.emplace_back(x, y);
  ASSERT_FALSE(circle.empty());
  const cv::Rect box = cv::boundingRect(circle);
  EXPECT_NEAR(box.width, box.height, 4);
  EXPECT_NEAR(box.x, way_before.x, 5);
  const double px_per_m = box.height / 8.0;
  EXPECT_NEAR(way_before.y - way_after.y, (15 - 5.5) * px_per_m, 0.6 * px_per_m);
  EXPECT_GT(box.x + box.width / 2, way_before.x);  // east is right
}

TEST_F(PlotsTest, WithoutRowsThereIsNothingToDraw) {
  DrawPlots(folder_, {}, {});
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(PlotsTest, APlotThatGnuplotRefusesIsNamedAndTakesNoneOfTheOthersAlong) {
  const auto always = [](const std::vector<LogRow>&) { return true; };
  const auto script = [](const char* line) {
    return [line](const std::filesystem::path& file, const std::vector<LogRow>&, const mission::FigureText&) {
      return BeginFigure(file, 300, 200) + line + EndFigure();
    };
  };
  mission::MissionType type;
  type.plots = {{"wrong.png", always, script("plotte x\n")}, {"right.png", always, script("plot x\n")}};
  try {
    DrawPlots(folder_, Climb({0, 0, 0}, 0), PlotsOf(type));
    ADD_FAILURE() << "drawn";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), testing::AllOf(testing::HasSubstr("wrong.png"),
                                         testing::Not(testing::HasSubstr("right.png"))));
  }
  EXPECT_FALSE(Picture("right.png").empty());
  EXPECT_FALSE(Picture("position.png").empty());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "wrong.png"));
}

TEST_F(PlotsTest, ATitleRunsNothing) {
  const auto victim = folder_ / "ran";
  DrawPlots(folder_, Climb({0, 0, 0}, 0),
            {"`touch " + victim.string() + "` '.system('touch " + victim.string() + "').'", kPad_m});
  EXPECT_FALSE(std::filesystem::exists(victim));
  EXPECT_FALSE(Picture("position.png").empty());
}

}  // namespace
}  // namespace kestrel::records
