// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "geometry/tait_bryan.h"
#include "sim/camera/pan_tilt.h"
#include "tests/sim/hover.h"

// The simulated camera on a pan-tilt platform.
namespace kestrel::sim {
namespace {

SimulatorParameters Hovering() {
  SimulatorParameters p = Hover();
  p.wind = {};
  p.image.noise_grey = 0;
  p.duration_s = 0.6;
  return p;
}

double GreyLevelsApart(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

std::vector<cv::Mat> Frames(Simulator& simulator) {
  std::vector<cv::Mat> frames;
  while (const auto frame = simulator.Next()) frames.push_back(frame->image.clone());
  return frames;
}

TEST(CameraPlatform, TurnedTheCameraSeesWhatOneMountedSoSees) {
  SimulatorParameters p = Hovering();
  PanTilt platform({.rate_deg_s = 1000}, p.mount.position_m, AnglesOf(p.mount, {}).value());
  platform.Turn(LookFromAircraft{Radians(20), Radians(-70)});
  Simulator turned(p);
  turned.CarryCamera(&platform);
  const std::vector<cv::Mat> seen = Frames(turned);
  EXPECT_LT(turned.X_BC().R.angularDistance(platform.X_BC().R), 1e-12);

  Simulator ahead(p);  // where the camera was before
  p.mount.yaw_deg = 20, p.mount.pitch_deg = 20;
  Simulator mounted(p);
  const std::vector<cv::Mat> wanted = Frames(mounted), before = Frames(ahead);
  ASSERT_EQ(seen.size(), wanted.size());
  for (std::size_t i = 2; i < seen.size(); ++i) {  // the first is exposed before it has turned
    EXPECT_LT(GreyLevelsApart(seen[i], wanted[i]), 0.01) << i;
    EXPECT_GT(GreyLevelsApart(seen[i], before[i]), 1) << i;
  }
  EXPECT_EQ(turned.state_hash(), mounted.state_hash());  // the aircraft does not feel it
}

TEST(CameraPlatform, WhileItTurnsAnExposureIsBlurred) {
  const auto contrast = [](double exposure_s, bool turns) {  // between neighbours in a row
    SimulatorParameters p = Hovering();
    p.mount.pitch_deg = 30;
    p.image.exposure = {.time_s = exposure_s, .samples = 8};
    Simulator simulator(p);
    PanTilt platform({.rate_deg_s = 60}, p.mount.position_m, AnglesOf(p.mount, {}).value());
    if (turns) platform.Turn(LookFromAircraft{Radians(90), Radians(-60)});
    simulator.CarryCamera(&platform);
    double sum = 0;
    for (const cv::Mat& image : Frames(simulator))
      sum += cv::norm(image.colRange(1, image.cols), image.colRange(0, image.cols - 1), cv::NORM_L2SQR);
    return sum;
  };
  // The aircraft's own motion blurs as well.
  const double still = contrast(0.03, false) / contrast(0, false);
  EXPECT_LT(contrast(0.03, true) / contrast(0, true), 0.8 * still);
}

TEST(CameraPlatform, KeepsAPlaceInTheMiddleOfTheImageWhileTheAircraftMoves) {
  SimulatorParameters p = Hovering();
  p.duration_s = 3;
  p.start.offset_m = {-4, 0};  // not straight above it, where the pan turns by any angle in no time
  PanTilt platform({}, p.mount.position_m, AnglesOf(p.mount, {}).value());
  Simulator simulator(p);
  simulator.CarryCamera(&platform);
  const Eigen::Vector3d pad_N = simulator.truth().X_NT.p;
  platform.Turn(LookAt{pad_N});
  simulator.Send(control::VelocitySetpoint{{1, 0.5, 0}, 0});
  const Eigen::Vector3d began_N = simulator.truth().X_NB.p;
  double moved_m = 0;
  while (simulator.Next()) {
    simulator.Send(control::VelocitySetpoint{{1, 0.5, 0}, 0});
    if (simulator.truth().t_s < 1) continue;
    const control::VehicleState believed = simulator.State();
    const Pose X_NC = Pose{believed.R_NB, believed.p_NB} * simulator.X_BC();
    const auto uv = vision::Project(p.camera, X_NC.Inverse() * pad_N);
    ASSERT_TRUE(uv);
    EXPECT_LT((*uv - Eigen::Vector2d(79.5, 59.5)).norm(), 3);  // px: a degree, for the state of a step before
    moved_m = (simulator.truth().X_NB.p - began_N).norm();
  }
  EXPECT_GT(moved_m, 1);
}

}  // namespace
}  // namespace kestrel::sim
