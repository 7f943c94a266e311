// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/gravity.h"
#include "base/nanoseconds.h"
#include "sim/instrument/motion.h"
#include "tests/sim/hover.h"

// What the aircraft carries beside what it flies by.
namespace kestrel::sim {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

CarriedCameraParameters Camera(const std::string& name) {
  CarriedCameraParameters camera;
  camera.name = name;
  camera.camera = vision::Pinhole{48, 32, 60, 60, 23.5, 15.5};
  camera.image.latency_s = 0.03;
  return camera;
}

ImuParameters WithoutNoise() {
  ImuParameters imu;
  imu.accelerometer_noise_density = imu.accelerometer_random_walk = imu.accelerometer_turn_on_m_s2 = 0;
  imu.gyroscope_noise_density = imu.gyroscope_random_walk = imu.gyroscope_turn_on_rad_s = 0;
  return imu;
}

SimulatorParameters Small() {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{32, 24, 40, 40, 15.5, 11.5};
  return p;
}

struct Carried {
  std::vector<Truth> exposures;  // of the main camera
  std::vector<CameraFrame> frames;
  Readings readings;
  std::vector<double> given_s;  // when each of the frames was given
};

Carried Fly(const SimulatorParameters& p) {
  Simulator simulator(p);
  Carried all;
  const auto gather = [&] {
    Append(all.readings, simulator.readings());
    for (const CameraFrame& frame : simulator.camera_frames()) {
      all.frames.push_back(frame);
      all.given_s.push_back(simulator.truth().t_s);
    }
  };
  while (simulator.Next()) {
    all.exposures.push_back(simulator.exposure());
    gather();
  }
  return all;
}

std::vector<CameraFrame> Of(const std::string& name, const Carried& all) {
  std::vector<CameraFrame> frames;
  for (const CameraFrame& frame : all.frames)
    if (frame.name == name) frames.push_back(frame);
  return frames;
}

TEST(Equipment, ChangesNothingOfTheFlightNorOfItsImages) {
  SimulatorParameters p = Small();
  const Watched bare = Watch(p);
  p.instruments.imu.emplace(), p.instruments.gps.emplace(), p.instruments.barometer.emplace();
  p.instruments.magnetometer.emplace(), p.instruments.rangefinder.emplace();
  p.cameras = {Camera("left"), Camera("right")};
  const Watched laden = Watch(p);
  EXPECT_EQ(laden.state_hash, bare.state_hash);
  EXPECT_EQ(laden.image_hash, bare.image_hash);
  EXPECT_EQ(laden.given_s, bare.given_s);
}

// The images, the IMU and the truth have one clock, and where their instants are the same so are their stamps.
TEST(Equipment, StampsOfImageImuAndTruthAreTheSameToTheNanosecond) {
  SimulatorParameters p = Small();
  p.image.rate_hz = 25;
  p.instruments.imu = WithoutNoise();
  p.instruments.imu->rate_hz = 500;
  p.cameras = {Camera("left")};
  p.cameras[0].image.rate_hz = 50;
  const Carried all = Fly(p);
  const Readings& readings = all.readings;
  ASSERT_GT(readings.imu.size(), 200u);
  ASSERT_EQ(readings.truth.size(), readings.imu.size());
  for (std::size_t i = 0; i < readings.imu.size(); ++i) {
    ASSERT_EQ(readings.imu[i].t_ns, static_cast<std::int64_t>(i) * 2'000'000);
    ASSERT_EQ(readings.truth[i].t_ns, readings.imu[i].t_ns);
    ASSERT_EQ(readings.imu[i].w_I, readings.truth[i].w_B);
  }
  ASSERT_GT(all.exposures.size(), 9u);
  for (const Truth& exposure : all.exposures) {
    const std::int64_t t_ns = Nanoseconds(exposure.t_s);
    EXPECT_EQ(t_ns % 40'000'000, 0);
    const TruthSample& there = readings.truth.at(static_cast<std::size_t>(t_ns / 2'000'000));
    EXPECT_EQ(there.t_ns, t_ns);
    EXPECT_LT((there.X_NB.p - exposure.X_NB.p).norm(), 1e-15);
    EXPECT_LT((there.v_N - exposure.v_N).norm(), 1e-15);
  }
  ASSERT_GT(all.frames.size(), 19u);
  for (const CameraFrame& frame : all.frames) {
    const std::int64_t t_ns = Nanoseconds(frame.frame.t_s);
    EXPECT_EQ(t_ns, frame.frame.sequence * 20'000'000);
    const TruthSample& there = readings.truth.at(static_cast<std::size_t>(t_ns / 2'000'000));
    EXPECT_LT(((there.X_NB * vision::MountPose({})).p - frame.X_NC.p).norm(), 1e-14);
  }
}

// What the IMU says, integrated from the truth at the beginning, leads to the truth at the end.
TEST(Equipment, AnImuWithoutNoiseLeadsWhereTheAircraftGoes) {
  SimulatorParameters p = Small();
  p.images = false;
  p.duration_s = 2;
  p.instruments.imu = WithoutNoise();
  p.instruments.imu->rate_hz = 1000;
  const Readings readings = Fly(p).readings;
  TruthSample at = readings.truth.front();
  const double dt_s = 0.001;
  for (std::size_t i = 1; i < readings.imu.size(); ++i) {
    const Eigen::Vector3d mid_w = (readings.imu[i - 1].w_I + readings.imu[i].w_I) / 2;
    const Eigen::Quaterniond R_mid = at.X_NB.R * ExpRotation(mid_w * dt_s / 2);
    const Eigen::Vector3d a_N =
        R_mid * readings.imu[i].specific_force_I + Eigen::Vector3d(0, 0, kGravity_m_s2);
    at.X_NB.p += dt_s * (at.v_N + dt_s / 2 * a_N);
    at.v_N += dt_s * a_N;
    at.X_NB.R = at.X_NB.R * ExpRotation(mid_w * dt_s);
  }
  EXPECT_LT((at.X_NB.p - readings.truth.back().X_NB.p).norm(), 0.02);
  EXPECT_LT((at.v_N - readings.truth.back().v_N).norm(), 0.02);
  EXPECT_LT(at.X_NB.R.angularDistance(readings.truth.back().X_NB.R), 1e-3);
}

TEST(Equipment, ARangefinderMeasuresThePadAndTheGroundAndNotItsOwnAircraft) {
  SimulatorParameters p = Small();
  p.images = false;
  p.instruments.imu = WithoutNoise();
  p.instruments.imu->rate_hz = 50;
  p.instruments.rangefinder.emplace().noise_m = 0;
  const Eigen::Vector2d pad_half_m(1.19 / 2, 0.91 / 2);
  for (const double north_m : {0.0, 5.0}) {
    p.start.offset_m = {north_m, 0};
    const Readings readings = Fly(p).readings;
    ASSERT_GT(readings.rangefinder.size(), 20u);
    int on_pad = 0;
    for (std::size_t i = 0; i < readings.rangefinder.size(); ++i) {
      ASSERT_EQ(readings.rangefinder[i].t_ns, readings.truth[i].t_ns);
      const Pose& X_NB = readings.truth[i].X_NB;
      const Eigen::Vector3d down_N = X_NB.R * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d foot_N = X_NB.p - X_NB.p.z() / down_N.z() * down_N;
      const double beside_m = (foot_N.head<2>().cwiseAbs() - pad_half_m).maxCoeff();
      if (std::abs(beside_m) < 0.01) continue;  // of the pad's edge
      const double surface_m = beside_m < 0 ? 0.01 : 0;
      EXPECT_NEAR(readings.rangefinder[i].range_m, (-X_NB.p.z() - surface_m) / down_N.z(), 1e-9);
      on_pad += beside_m < 0;
    }
    EXPECT_EQ(on_pad > 5, north_m == 0);
  }
}

TEST(Equipment, ReadingsAndFramesAreTheSameInWhateverSlicesTheTimePasses) {
  SimulatorParameters p = Small();
  p.instruments.imu.emplace();
  p.cameras = {Camera("left")};
  const Carried whole = Fly(p);
  Simulator simulator(p);
  Readings sliced;
  std::vector<CameraFrame> frames;
  for (double t_s = 0; t_s < 0.6; t_s += 0.006) {
    while (true) {
      const bool came = simulator.NextUntil(t_s).has_value();
      Append(sliced, simulator.readings());
      for (const CameraFrame& frame : simulator.camera_frames()) frames.push_back(frame);
      if (!came) break;
    }
  }
  ASSERT_GE(sliced.imu.size(), whole.readings.imu.size());
  for (std::size_t i = 0; i < whole.readings.imu.size(); ++i) {
    EXPECT_EQ(sliced.imu[i].t_ns, whole.readings.imu[i].t_ns);
    EXPECT_EQ(sliced.imu[i].specific_force_I, whole.readings.imu[i].specific_force_I);
  }
  ASSERT_GE(frames.size(), whole.frames.size());
  for (std::size_t i = 0; i < whole.frames.size(); ++i)
    EXPECT_TRUE(Same(frames[i].frame.image, whole.frames[i].frame.image));
}

TEST(FurtherCameras, TriggeredByTheMainOneExposeWithIt) {
  SimulatorParameters p = Small();
  p.image.rate_hz = 30;  // its instants are not whole periods
  p.cameras = {Camera("left"), Camera("free")};
  p.cameras[0].image.rate_hz = 30;
  p.cameras[0].image.exposure.time_s = 0.004;
  p.cameras[1].image.rate_hz = 30;
  p.cameras[1].timing = {.phase_s = 0.01, .drift_ppm = 5000};
  const Carried all = Fly(p);
  const auto left = Of("left", all), free = Of("free", all);
  ASSERT_GE(left.size(), all.exposures.size());
  for (std::size_t i = 0; i < all.exposures.size(); ++i) {
    EXPECT_EQ(left[i].frame.t_s, all.exposures[i].t_s);
    EXPECT_EQ(left[i].X_NC.p, (all.exposures[i].X_NB * vision::MountPose({})).p);
  }
  ASSERT_GT(free.size(), 10u);
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double due_s = 0.01 + static_cast<double>(i) / (30 * 1.005);
    EXPECT_EQ(free[i].frame.t_s, 0.002 * static_cast<double>(std::llround(due_s / 0.002)));
  }
}

TEST(FurtherCameras, FramesComeAfterTheirOwnLatencyAndFaultsAreTheirOwn) {
  SimulatorParameters p = Small();
  p.image.rate_hz = 50;
  p.cameras = {Camera("slow"), Camera("broken")};
  p.cameras[0].image.latency_s = 0.1;
  p.cameras[1].image.faults = {{.type = "off", .from_s = 0.19, .until_s = 1}};
  const Carried all = Fly(p);
  for (std::size_t i = 0; i < all.frames.size(); ++i) {
    const double latency_s = all.frames[i].name == "slow" ? 0.1 : 0.03;
    EXPECT_GE(all.given_s[i], all.frames[i].frame.t_s + latency_s - 1e-9);
  }
  EXPECT_EQ(Of("slow", all).size(), 10u);  // those until 0.1 s before the last frame of the main camera came
  EXPECT_EQ(Of("broken", all).size(), 4u);
}

TEST(FurtherCameras, WhatOneShowsDoesNotDependOnTheOthers) {
  SimulatorParameters p = Small();
  p.duration_s = 0.2;
  p.cameras = {Camera("left")};
  const auto alone = Of("left", Fly(p));
  p.cameras = {Camera("right"), Camera("left")};
  const Carried both = Fly(p);
  const auto left = Of("left", both), right = Of("right", both);
  ASSERT_EQ(left.size(), alone.size());
  ASSERT_EQ(right.size(), alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_TRUE(Same(left[i].frame.image, alone[i].frame.image));
    EXPECT_FALSE(Same(right[i].frame.image, left[i].frame.image));  // its noise is its own
  }
}

// Where the corner of the pad's black frame is, near there.
Eigen::Vector2d CornerNear(const cv::Mat& image, const Eigen::Vector2d& uv) {
  std::vector<cv::Point2f> corner = {{static_cast<float>(uv.x()), static_cast<float>(uv.y())}};
  cv::cornerSubPix(image, corner, {5, 5}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 60, 1e-4});
  return {corner[0].x, corner[0].y};
}

TEST(FurtherCameras, AStereoPairHasItsBaselineInPosesAndInPictures) {
  SimulatorParameters p = Small();
  p.image.rate_hz = 10;
  p.wind = {}, p.duration_s = 0.25;  // so that the corner is in view
  const vision::Pinhole pinhole{640, 480, 1400, 1400, 319.5, 239.5};
  for (const double side : {-0.1, 0.1}) {
    CarriedCameraParameters& camera = p.cameras.emplace_back(Camera(side < 0 ? "left" : "right"));
    camera.camera = pinhole;
    camera.image.rate_hz = 10, camera.image.noise_grey = 0;
    camera.mount.position_m = {0.1, side, 0.05};
  }
  const Carried all = Fly(p);
  const auto left = Of("left", all), right = Of("right", all);
  ASSERT_EQ(left.size(), right.size());
  ASSERT_EQ(left.size(), 3u);
  // The outer corner of the pad's black frame, 30 mm from the pad's edges (helipad.svg).
  const Eigen::Vector3d corner_T(1.19 / 2 - 0.03, -(0.91 / 2 - 0.03), 0);
  for (std::size_t i = 0; i < left.size(); ++i) {
    EXPECT_EQ(left[i].frame.t_s, right[i].frame.t_s);
    const Pose X_LR = left[i].X_NC.Inverse() * right[i].X_NC;
    EXPECT_LT((X_LR.p - Eigen::Vector3d(0.2, 0, 0)).norm(), 1e-12);
    EXPECT_LT(X_LR.R.angularDistance(Eigen::Quaterniond::Identity()), 1e-7);

    const Eigen::Vector3d corner_N = all.exposures[i].X_NT * corner_T;
    const Eigen::Vector3d in_left = left[i].X_NC.Inverse() * corner_N;
    const auto expected_left = vision::Project(pinhole, in_left);
    const auto expected_right = vision::Project(pinhole, right[i].X_NC.Inverse() * corner_N);
    ASSERT_TRUE(expected_left && expected_right);
    const Eigen::Vector2d off(1.5, -1);
    const Eigen::Vector2d seen_left = CornerNear(left[i].frame.image, *expected_left + off);
    const Eigen::Vector2d seen_right = CornerNear(right[i].frame.image, *expected_right - off);
    EXPECT_LT((seen_left - *expected_left).norm(), 0.5);
    // Depth by disparity: f b / Z.
    EXPECT_NEAR((seen_left - seen_right).x(), 1400 * 0.2 / in_left.z(), 0.15);
    EXPECT_NEAR((seen_left - seen_right).y(), 0, 0.15);
  }
}

TEST(FurtherCameras, GiveSurfacesAndFlowWhereTheyAreAskedFor) {
  SimulatorParameters p = Small();
  p.surfaces = true;
  p.duration_s = 0.3;
  p.cameras = {Camera("left")};
  const Carried all = Fly(p);
  ASSERT_GE(all.frames.size(), 4u);
  for (const CameraFrame& frame : all.frames) {
    EXPECT_EQ(frame.surfaces.depth_m.size(), cv::Size(48, 32));
    EXPECT_EQ(frame.flow.empty(), frame.frame.sequence == 0);
  }
  p.images = false;
  const Carried blind = Fly(p);
  EXPECT_EQ(blind.frames.size(), all.frames.size());
  for (const CameraFrame& frame : blind.frames) EXPECT_TRUE(frame.frame.image.empty());
}

}  // namespace
}  // namespace kestrel::sim
