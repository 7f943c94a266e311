// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/corner_motion.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <numbers>

#include "geometry/tait_bryan.h"
#include "scenarios/stabilise/stabilise_metrics.h"
#include "scenarios/stabilise/stabilise_report.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRate_hz = 30;

std::vector<double> StepsOf(const std::function<double(double)>& path, int n) {
  std::vector<double> steps;
  for (int i = 0; i < n; ++i) steps.push_back(path((i + 1) / kRate_hz) - path(i / kRate_hz));
  return steps;
}
double Tone(double amplitude, double hz, double t_s) {
  return amplitude * std::sin(2 * std::numbers::pi * hz * t_s + 0.7);
}

TEST(BandRms, IsThatOfATone) {
  for (const double hz : {0.8, 3.1, 9.77, 14.0}) {
    const auto steps = StepsOf([&](double t) { return Tone(2, hz, t); }, 901);
    EXPECT_NEAR(BandRms(steps, kRate_hz, 0.5, 15), std::sqrt(2.0), 0.02) << hz;
  }
}

TEST(BandRms, OfTwoTonesOneIsOutside) {
  const auto steps = StepsOf([](double t) { return Tone(1, 4, t) + Tone(5, 0.2, t) + 90 * t; }, 900);
  EXPECT_NEAR(BandRms(steps, kRate_hz, 0.5, 15), 1 / std::sqrt(2.0), 0.01);
  EXPECT_NEAR(BandRms(steps, kRate_hz, 3, 5), 1 / std::sqrt(2.0), 0.01);
  EXPECT_LT(BandRms(steps, kRate_hz, 5, 15), 0.01);
}

TEST(BandRms, OfTooFewStepsThereIsNone) { EXPECT_EQ(BandRms({1, 2, 3}, kRate_hz, 0.5, 15), 0); }

const vision::Pinhole kCamera{640, 480, 800, 800, 319.5, 239.5};

// A camera that looks down from 12 m, goes north, and shakes.
Pose CameraAt(double t_s) {
  Matrix3d looks_down;
  looks_down << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Matrix3d R_NB =
      RotationFromTaitBryan({Tone(0.004, 4, t_s), Tone(0.006, 3, t_s), Tone(0.005, 7, t_s + 0.3)});
  return {Eigen::Quaterniond(R_NB * looks_down), {2 * t_s, Tone(0.01, 5, t_s), -12}};
}

// From px of one image to px of another by the ground, z = 0: H = K2 (R + t n' / d) K1^-1, thesis 3.16.
Matrix3d Homography(const Pose& X_NA, const Pose& X_NB) {
  const Pose X_BA = X_NB.Inverse() * X_NA;
  const Vector3d n_A = X_NA.R.conjugate() * Vector3d::UnitZ();
  const double d = -X_NA.p.z();
  return kCamera.K() * (X_BA.R.toRotationMatrix() + X_BA.p * n_A.transpose() / d) * kCamera.K().inverse();
}

Vector2d Mapped(const Matrix3d& H, const Vector2d& uv) { return (H * uv.homogeneous()).hnormalized(); }

std::vector<mission::LogRow> Flight(int images, const std::function<Matrix3d(int)>& view) {
  const auto camera = std::make_shared<vision::CameraModel>(kCamera);
  std::vector<mission::LogRow> rows;
  for (int i = 0; i < images; ++i) {
    mission::LogRow row;
    row.sequence = i;
    row.exposure.t_s = i / kRate_hz, row.now.t_s = row.exposure.t_s + 0.05;
    row.exposure.X_NC = CameraAt(row.exposure.t_s);
    auto report = std::make_shared<StabiliseReport>();
    report->camera = camera;
    report->shown = ShownImage{i, row.exposure.t_s, vision::StabilisedState::kFollowed, 100, 1, {}};
    report->shown->view.size = {640, 480};
    report->shown->view.H = view(i);
    row.decision.report = report;
    rows.push_back(row);
  }
  return rows;
}

TEST(CornerFlows, OfAViewThatStandsStillInTheImageAreThoseOfTheGround) {
  const auto rows = Flight(20, [](int) { return Matrix3d::Identity(); });
  const std::vector<CornerFlow> flows = CornerFlows(rows);
  ASSERT_EQ(flows.size(), 19u);
  const Vector2d corners[] = {{0, 0}, {639, 0}, {639, 479}, {0, 479}};
  for (std::size_t k = 0; k < flows.size(); ++k) {
    const Matrix3d H = Homography(rows[k].exposure.X_NC, rows[k + 1].exposure.X_NC);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT((flows[k].in[i] - (Mapped(H, corners[i]) - corners[i])).norm(), 1e-6);
      EXPECT_LT((flows[k].out[i] - flows[k].in[i]).norm(), 1e-6);
    }
    EXPECT_GT(flows[k].in[0].norm(), 0.5);
  }
}

TEST(CornerFlows, OfAViewThatStandsStillOnTheGroundAreNone) {
  const auto rows = Flight(90, [](int i) {
    Matrix3d H = Homography(CameraAt(i / kRate_hz), CameraAt(0));
    return Matrix3d(H / H(2, 2));
  });
  std::map<std::string, double> metrics;
  AddStabiliseMetrics(rows, metrics);
  for (const CornerFlow& flow : CornerFlows(rows))
    for (const Vector2d& out : flow.out) EXPECT_LT(out.norm(), 1e-6);
  EXPECT_GT(metrics.at("jitter_in_px"), 1);
  EXPECT_LT(metrics.at("jitter_left"), 1e-6);
  EXPECT_EQ(metrics.at("stabilised_share"), 1);
  EXPECT_NEAR(metrics.at("stabilised_late_s"), 0.05, 1e-9);
  for (const mission::Metric& metric : StabiliseMetrics())
    EXPECT_TRUE(metrics.count(metric.name)) << metric.name;
}

TEST(CornerFlows, AreOfTheLongestRunWithoutAGap) {
  auto rows = Flight(30, [](int) { return Matrix3d::Identity(); });
  rows.erase(rows.begin() + 10);
  EXPECT_EQ(CornerFlows(rows).size(), 18u);
}

TEST(StabiliseMetrics, OfAViewThatStandsStillInTheImageAllJitterIsLeft) {
  std::map<std::string, double> metrics;
  AddStabiliseMetrics(Flight(90, [](int) { return Matrix3d::Identity(); }), metrics);
  EXPECT_NEAR(metrics.at("jitter_left"), 1, 1e-9);
}

TEST(StabiliseMetrics, WithoutAnImageThereAreNone) {
  std::map<std::string, double> metrics;
  AddStabiliseMetrics(std::vector<mission::LogRow>(3), metrics);
  EXPECT_TRUE(metrics.empty());
}

}  // namespace
}  // namespace kestrel::scenarios
