// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hand_held/hand_held_metrics.h"

#include <gtest/gtest.h>

#include "geometry/tait_bryan.h"
#include "scenarios/hand_held/hand_held_report.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

const Pose kX_BC{Eigen::Quaterniond((Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished()),
                 {0.25, 0, 0}};
// On a wall in the north: its picture's up is up.
const Pose kX_NT{Eigen::Quaterniond((Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished()),
                 {3.5, 0.1, -1.4}};

// What the camera sees, off by this much in C.
vision::PadObservation Seen(const Pose& X_NB, const Vector3d& error_C) {
  vision::PadObservation seen;
  seen.X_CT = (X_NB * kX_BC).Inverse() * kX_NT;
  seen.X_CT.p += error_C;
  seen.covariance = 1e-4 * Eigen::Matrix<double, 6, 6>::Identity();  // sigma of 1 cm, and of 0.01 rad
  return seen;
}

records::LogRow Row(const Pose& X_NB, const Vector3d& error_C, const Vector3d& chain_error_C) {
  records::LogRow row;
  row.exposure.X_NB = X_NB, row.exposure.X_NT = kX_NT;
  const auto report = std::make_shared<HandHeldReport>();
  report->X_BC = kX_BC;
  report->seen = Seen(X_NB, error_C), report->chained = Seen(X_NB, chain_error_C);
  row.decision.report = report;
  return row;
}

TEST(HandHeld, TheRoomsAxesAreThoseOfTheMotionCapture) {
  // East of the landmark by a metre, 3 m before it, turned to the left by 20 degrees.
  const Pose X_NB{HeadingRotation(Radians(-20)), {0.5, 1.1, -1.4}};
  const RoomPlace place = InRoom({X_NB.R * kX_BC.R, X_NB.p});
  EXPECT_LT((place.p - Vector3d(1.1, 0.5, 1.4)).norm(), 1e-12);
  EXPECT_NEAR(Degrees(place.yaw), 20, 1e-9);
}

TEST(HandHeldMetrics, TellTheErrorsOfTheLandmarkAndOfTheCamera) {
  const Pose ahead{HeadingRotation(0), {0.5, 0.1, -1.4}};
  const std::vector<records::LogRow> rows(5, Row(ahead, {0.01, -0.002, 0.02}, {0.3, 0, 0.4}));
  std::map<std::string, double> m;
  AddHandHeldMetrics(rows, m);
  for (const mission::Metric& metric : HandHeldMetrics()) EXPECT_TRUE(m.count(metric.name)) << metric.name;
  EXPECT_NEAR(m["landmark_x_rmse_m"], 0.01, 1e-9);
  EXPECT_NEAR(m["landmark_y_rmse_m"], 0.002, 1e-9);
  EXPECT_NEAR(m["landmark_z_rmse_m"], 0.02, 1e-9);
  // A level camera that looks at the wall: across, depth and height of the room are x, z and y of the image.
  EXPECT_NEAR(m["camera_x_rmse_m"], 0.01, 1e-9);
  EXPECT_NEAR(m["camera_y_rmse_m"], 0.02, 1e-9);
  EXPECT_NEAR(m["camera_z_rmse_m"], 0.002, 1e-9);
  EXPECT_NEAR(m["camera_yaw_rmse_deg"], 0, 1e-9);
  EXPECT_EQ(m["within_95_share"], 1);  // 0.0224 m of sigmas of 0.01 m: 5 of 12.6
  EXPECT_EQ(m["landmark_share"], 1);
  EXPECT_NEAR(m["chain_drift_m"], 0.5, 1e-9);
  EXPECT_NEAR(m["chain_landmark_z_rmse_m"], 0.4, 1e-9);
}

TEST(HandHeldMetrics, AnErrorBeyondItsCovarianceIsTold) {
  const Pose ahead{HeadingRotation(0), {0.5, 0.1, -1.4}};
  std::vector<records::LogRow> rows = {Row(ahead, {0.03, 0, 0}, {0, 0, 0}),
                                       Row(ahead, {0.04, 0, 0}, {0, 0, 0})};
  std::map<std::string, double> m;
  AddHandHeldMetrics(rows, m);
  EXPECT_EQ(m["within_95_share"], 0.5);  // 9 and 16 of 12.6
}

}  // namespace
}  // namespace kestrel::scenarios
