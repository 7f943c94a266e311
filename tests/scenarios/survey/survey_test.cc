// SPDX-License-Identifier: Apache-2.0
#include "scenarios/survey/survey.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <memory>

#include "geometry/tait_bryan.h"
#include "mission/mosaic/mosaic_report.h"
#include "scenarios/survey/survey_metrics.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(SurveyLines, GoBackAndForthSideBySide) {
  SurveyFlight flight;
  flight.height_m = 20, flight.begin_m = {10, -5}, flight.heading_deg = 90;
  flight.lines = 4, flight.line_m = 30, flight.spacing_m = 8;
  const auto path = SurveyLines(flight, {1, 2, -3}, Radians(-170));
  ASSERT_EQ(path.size(), 2u + 4 + 3);
  EXPECT_EQ(path[0].p_N, Vector3d(1, 2, -3));
  EXPECT_LT((path[1].p_N - Vector3d(10, -5, -20)).norm(), 1e-9);
  int lines = 0;
  for (std::size_t i = 2; i < path.size(); ++i) {
    const Vector3d way = path[i].p_N - path[i - 1].p_N;
    const bool line = path[i].phase == "line";
    // Heading east: lines along y, shifts to the right, which is south.
    const double along = lines % 2 == 0 ? 30 : -30;
    EXPECT_LT((way - (line ? Vector3d(0, along, 0) : Vector3d(-8, 0, 0))).norm(), 1e-9) << i;
    EXPECT_NEAR(WrapAngle(path[i].yaw - Radians(90)), 0, 1e-9);
    lines += line;
  }
  EXPECT_EQ(lines, 4);
  EXPECT_LT(std::abs(path[1].yaw - path[0].yaw), Radians(101));  // the shorter way round
}

constexpr double kHeight_m = 40;
const vision::Pinhole kCamera{640, 480, 400, 400, 319.5, 239.5};

Pose CameraAt(double north, double east) {
  Matrix3d looks_down;
  looks_down << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Matrix3d R_NB = RotationFromTaitBryan({0.1 + 0.002 * north, 0.03, -0.02 - 0.001 * east});
  return {Eigen::Quaterniond(R_NB * looks_down), {north, east, -kHeight_m}};
}

// Takes rays of a camera to the ground, and that to a mosaic that lies askew.
Matrix3d TrueM_WC(const Pose& X_NC) {
  Matrix3d to_ground;  // (x, y, 1) ~ of the ray r: p - p.z / r.z r
  const Matrix3d R = X_NC.R.toRotationMatrix();
  to_ground.row(0) = X_NC.p.x() * R.row(2) - X_NC.p.z() * R.row(0);
  to_ground.row(1) = X_NC.p.y() * R.row(2) - X_NC.p.z() * R.row(1);
  to_ground.row(2) = R.row(2);
  Matrix3d askew;
  askew << 0.02, 0.003, 0.1, -0.002, 0.025, -0.2, 1e-5, -2e-5, 1;
  return askew * to_ground;
}

// Two lines side by side. shift: of all images of the second in the mosaic, px.
std::map<std::string, double> MetricsOf(double shift_px, bool chained) {
  const vision::Projection projection(kCamera, vision::Surface::kPlane, kCamera.fx);
  mission::FinishedMosaic finished{projection, {}, {}, std::nullopt};
  std::vector<mission::LogRow> rows;
  for (int i = 0; i < 40; ++i) {
    mission::LogRow row;
    row.sequence = 3 * i;
    row.exposure.t_s = i;
    row.exposure.X_NC = i < 20 ? CameraAt(3 * i, 0) : CameraAt(3 * (39 - i), 20);
    Matrix3d shifted = Matrix3d::Identity();
    if (i >= 20) shifted(0, 2) = shift_px / projection.f_px();
    const mission::PlacedImage placed{row.sequence, shifted * TrueM_WC(row.exposure.X_NC)};
    finished.placed.push_back(placed);
    if (chained) finished.chained.push_back(placed);
    row.decision.report = std::make_shared<mission::MosaicReport>();
    rows.push_back(row);
  }
  auto last = std::make_shared<mission::MosaicReport>();
  last->finished = std::make_shared<mission::FinishedMosaic>(finished);
  rows.back().decision.report = last;
  std::map<std::string, double> metrics;
  AddSurveyMetrics(rows, metrics);
  return metrics;
}

TEST(SurveyMetrics, ATrueMosaicHasNoErrorsHoweverItLies) {
  const auto metrics = MetricsOf(0, false);
  EXPECT_LT(metrics.at("mosaic_rms_px"), 1e-6);
  EXPECT_LT(metrics.at("mosaic_closure_px"), 1e-6);
  EXPECT_FALSE(metrics.count("chain_rms_px"));
  EXPECT_FALSE(metrics.count("georeference_rmse_m"));
}

TEST(SurveyMetrics, ASecondPassThatIsOffDoesNotClose) {
  const auto metrics = MetricsOf(5, true);
  EXPECT_NEAR(metrics.at("mosaic_closure_px"), 5, 1e-6);
  EXPECT_GT(metrics.at("mosaic_rms_px"), 0.5);
  EXPECT_LT(metrics.at("mosaic_rms_px"), 5);
  EXPECT_EQ(metrics.at("chain_rms_px"), metrics.at("mosaic_rms_px"));
}

}  // namespace
}  // namespace kestrel::scenarios
