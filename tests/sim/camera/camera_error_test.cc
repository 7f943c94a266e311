// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/camera_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr int kRuns = 4000;

// Of 4000 draws a standard deviation is known to 1.1 %, one standard deviation of its own.
constexpr double kShare = 0.05;

double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double each : values) sum += each * each;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(CameraErrors, WithoutParametersChangeNothingToTheLastBit) {
  const CameraError none({}, 3);
  const Pose X_BC{Eigen::Quaterniond(0.1, 0.7, -0.2, 0.6).normalized(), {0.1, -0.2, 0.3}};
  EXPECT_EQ(none.Of(X_BC).p, X_BC.p);
  EXPECT_EQ(none.Of(X_BC).R.coeffs(), X_BC.R.coeffs());
  for (const vision::CameraModel& camera : vision::CameraModels())
    EXPECT_EQ(vision::Parameters(none.Of(camera)), vision::Parameters(camera)) << vision::NameOf(camera);
  EXPECT_EQ(none.Stamp(12.345, 7), 12.345);
}

TEST(CameraErrors, AreAsLargeAsSaidAndOfTheSeed) {
  const CameraErrorParameters said{.focal = 0.01,
                                   .centre_px = 3,
                                   .position_m = 0.02,
                                   .angle_deg = 2,
                                   .clock_offset_s = 0.01,
                                   .clock_drift_ppm = 0,
                                   .clock_jitter_s = 0};
  const vision::Pinhole believed{640, 480, 800, 810, 320, 240};
  std::vector<double> focal, centre, distance, angle, offset;
  for (int seed = 0; seed < kRuns; ++seed) {
    const CameraError error(said, seed);
    const auto camera = std::get<vision::Pinhole>(error.Of(vision::CameraModel(believed)));
    focal.push_back(camera.fx / believed.fx - 1);
    EXPECT_NEAR(camera.fy / believed.fy - 1, focal.back(), 1e-12);
    centre.push_back(camera.cx - believed.cx);
    centre.push_back(camera.cy - believed.cy);
    const Pose X_MC = error.Of(Pose{});
    distance.push_back(X_MC.p.norm());
    angle.push_back(Degrees(X_MC.R.angularDistance(Eigen::Quaterniond::Identity())));
    offset.push_back(error.Stamp(5, 1) - 5);
  }
  EXPECT_NEAR(Rms(focal), 0.01, kShare * 0.01);
  EXPECT_NEAR(Rms(centre), 3, kShare * 3);
  EXPECT_NEAR(Rms(distance), 0.02, kShare * 0.02);
  EXPECT_NEAR(Rms(angle), 2, kShare * 2);
  EXPECT_NEAR(Rms(offset), 0.01, kShare * 0.01);
  EXPECT_EQ(CameraError(said, 8).Of(Pose{}).p, CameraError(said, 8).Of(Pose{}).p);
  EXPECT_NE(CameraError(said, 8).Of(Pose{}).p, CameraError(said, 9).Of(Pose{}).p);
}

TEST(CameraErrors, OfTheClockGrowWithTimeAndJitterByTheFrame) {
  const CameraErrorParameters drifts{.clock_drift_ppm = 100};
  std::vector<double> after_10_s;
  for (int seed = 0; seed < kRuns; ++seed) {
    const CameraError error(drifts, seed);
    after_10_s.push_back(error.Stamp(10, 3) - 10);
    EXPECT_NEAR(error.Stamp(20, 4) - 20, 2 * after_10_s.back(), 1e-9);
  }
  EXPECT_NEAR(Rms(after_10_s), 1e-3, kShare * 1e-3);
  const CameraError jitters({.clock_jitter_s = 0.002}, 5);
  std::vector<double> of_frames;
  double neighbours = 0;
  for (int i = 0; i < kRuns; ++i) {
    of_frames.push_back(jitters.Stamp(1, i) - 1);
    if (i > 0) neighbours += of_frames[i] * of_frames[i - 1] / kRuns;
  }
  EXPECT_NEAR(Rms(of_frames), 0.002, kShare * 0.002);
  EXPECT_LT(std::abs(neighbours), 0.06 * 0.002 * 0.002);  // they know nothing of each other
}

}  // namespace
}  // namespace kestrel::sim
