// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "sim/world/frames.h"
#include "tests/sim/hover.h"

namespace kestrel::sim {
namespace {

TEST(SimulatorExposure, ThatLastsChangesNeitherTheFlightNorTheTimes) {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{48, 32, 60, 60, 23.5, 15.5};
  const Watched sharp = Watch(p);
  p.image.exposure.time_s = 0.02;
  const Watched global = Watch(p);
  p.image.exposure.line_s = 0.001;
  const Watched rolling = Watch(p);
  for (const Watched* run : {&global, &rolling}) {
    EXPECT_EQ(run->state_hash, sharp.state_hash);
    ASSERT_EQ(run->frames.size(), sharp.frames.size());
    EXPECT_EQ(run->given_s, sharp.given_s);
    for (std::size_t i = 0; i < sharp.frames.size(); ++i) EXPECT_EQ(run->frames[i].t_s, sharp.frames[i].t_s);
  }
}

TEST(SimulatorExposure, NoFrameIsGivenBeforeItIsReadOut) {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{16, 16, 20, 20, 7.5, 7.5};
  p.image.exposure.time_s = 0.021, p.image.exposure.line_s = 0.001;
  p.image.latency_s = 0;  // which a scenario refuses
  const Watched run = Watch(p);
  EXPECT_EQ(run.frames.size(), 11u);
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    EXPECT_NEAR(run.given_s[i] - run.frames[i].t_s, 0.018, 1e-9);  // (21 + 15) / 2 ms, whole steps of 2 ms
}

TEST(SimulatorExposure, AVibratingMountMovesTheCameraAndNotTheAircraft) {
  SimulatorParameters p = Hover();
  p.image.noise_grey = 0, p.image.colour = true;
  p.duration_s = 0.2;
  const Watched still = Watch(p);
  p.mount.vibration = {{20, 60, 0.5, 3}};
  const Vibration vibration(p.mount.vibration, p.seed);

  Simulator simulator(p);
  EXPECT_EQ(simulator.X_BC().p, vision::MountPose(p.mount).p);
  const ModelPtr model = MakeModel(p.scene);
  const DataPtr data = MakeData(model.get());
  Renderer renderer(model.get(), p.camera, p.render);
  int frames = 0;
  for (; const auto frame = simulator.Next(); ++frames) {
    PoseToMujoco(simulator.exposure().X_NB, data->qpos);
    mj_forward(model.get(), data.get());
    const Pose X_NC = simulator.exposure().X_NB * simulator.X_BC() * vibration.At(frame->t_s);
    EXPECT_LT((simulator.exposure().X_NC.p - X_NC.p).norm(), 1e-12);
    EXPECT_LT(simulator.exposure().X_NC.R.angularDistance(X_NC.R), 1e-9);
    // The pose of the aircraft has gone through another frame and back.
    EXPECT_LT(cv::norm(renderer.Render(data.get(), X_NC), frame->image, cv::NORM_L1) / frame->image.total(),
              0.01);
    EXPECT_FALSE(Same(still.frames[frames].image, frame->image));
  }
  EXPECT_EQ(frames, 5);
  EXPECT_EQ(simulator.state_hash(), still.state_hash);
}

TEST(SimulatorExposure, AutoExposureBringsTheImageToItsLevelInOrderOfTheFrames) {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{48, 32, 60, 60, 23.5, 15.5};
  p.duration_s = 3;
  const auto mean = [](const vision::Frame& f) { return cv::mean(f.image)[0]; };
  const Watched fixed = Watch(p);
  p.image.auto_exposure.target_grey = 40, p.image.auto_exposure.lag_s = 0.3;
  const Watched automatic = Watch(p);
  EXPECT_GT(mean(fixed.frames.back()), 60);
  EXPECT_NEAR(mean(automatic.frames.front()), mean(fixed.frames.front()), 0.2);
  EXPECT_NEAR(mean(automatic.frames.back()), 40, 2);
  const double first = std::log(mean(automatic.frames[1]) / 40),
               later = std::log(mean(automatic.frames[7]) / 40);
  EXPECT_NEAR(later / first, std::exp(-0.3 / 0.3), 0.06);  // six periods after the first was metered
  // Frames under way do not matter, nor which are drawn while others wait.
  p.image.latency_s = 0.4;
  const Watched late = Watch(p);
  EXPECT_EQ(late.image_hash, automatic.image_hash);
  EXPECT_EQ(Watch(p).image_hash, automatic.image_hash);
}

TEST(SimulatorExposure, ScatterMakesEachSeedsCameraAnother) {
  SimulatorParameters p = Hover();
  p.duration_s = 0.1, p.wind = {}, p.image.noise_grey = 0, p.image.lens.vignetting = {-0.4, 0, 0};
  const std::uint64_t without = Watch(p).image_hash;
  p.image.scatter.vignetting = 0.3;
  const Watched with = Watch(p);
  EXPECT_NE(with.image_hash, without);
  EXPECT_EQ(with.image_hash, Watch(p).image_hash);
}

}  // namespace
}  // namespace kestrel::sim
