// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>

#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"
#include "tests/sim/hover.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Flown {
  std::uint64_t state_hash, image_hash;
  std::vector<cv::Mat> images;
  std::vector<Truth> exposures;
  bool operator==(const Flown& r) const { return state_hash == r.state_hash && image_hash == r.image_hash; }
};

Flown Fly(const SimulatorParameters& p) {
  Simulator simulator(p);
  Flown run{};
  while (const auto frame = simulator.Next()) {
    run.images.push_back(frame->image);
    run.exposures.push_back(simulator.exposure());
    simulator.Send(control::VelocitySetpoint{{0.3, -0.2, 0.1}, 0.1});
  }
  run.state_hash = simulator.state_hash(), run.image_hash = simulator.image_hash();
  return run;
}

TEST(Simulator, TimePassesOnlyInNext) {
  SimulatorParameters p = Hover();
  Simulator simulator(p);
  EXPECT_EQ(simulator.truth().t_s, 0);
  simulator.Send(control::VelocitySetpoint{{1, 0, 0}, 0});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(simulator.truth().t_s, 0);
  EXPECT_NEAR(simulator.State().t_s, 0, 1e-9);
  const auto frame = simulator.Next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->t_s, 0);
  EXPECT_EQ(frame->sequence, 0);
  EXPECT_NEAR(simulator.truth().t_s, 0.05, 1e-12);
  EXPECT_NEAR(simulator.State().t_s, 0.05, 1e-12);
  EXPECT_EQ(frame->image.size(), cv::Size(160, 120));
  EXPECT_EQ(frame->image.type(), CV_8UC1);
}

TEST(Simulator, ACameraThatIsOffSeesAsOneThatIsTrulySo) {
  SimulatorParameters off = Hover();
  off.camera_error = {.focal = 0.02, .centre_px = 3};
  SimulatorParameters truly = Hover();
  truly.camera = CameraError(off.camera_error, off.seed).Of(truly.camera);
  EXPECT_EQ(Fly(off), Fly(truly));
  const Flown right = Fly(Hover());
  EXPECT_NE(Fly(off).image_hash, right.image_hash);
  EXPECT_EQ(Fly(off).state_hash, right.state_hash);
  off.camera_error = {.position_m = 0.02, .angle_deg = 1, .clock_offset_s = 0.01};
  const Flown mounted = Fly(off);
  EXPECT_NE(mounted.image_hash, right.image_hash);
  EXPECT_EQ(mounted.state_hash, right.state_hash);
  Simulator simulator(off);
  EXPECT_EQ(simulator.Next()->t_s, CameraError(off.camera_error, off.seed).Stamp(0, 0));
  EXPECT_EQ(simulator.exposure().t_s, 0);
}

TEST(Simulator, AFlightInSlicesIsTheSameFlight) {
  SimulatorParameters p = Hover();
  p.image.faults = {{.type = "intermittent", .from_s = 0.1, .until_s = 0.3, .loss = 0.5}};
  const Flown whole = Fly(p);
  for (const double slice_s : {0.002, 0.037}) {
    Simulator simulator(p);
    Flown run{};
    for (int k = 1; k * slice_s < 1.2; ++k) {
      while (const auto frame = simulator.NextUntil(k * slice_s)) {
        EXPECT_LE(simulator.truth().t_s, k * slice_s + 1e-9);
        run.images.push_back(frame->image);
        EXPECT_EQ(frame->t_s, whole.exposures.at(run.images.size() - 1).t_s);
        simulator.Send(control::VelocitySetpoint{{0.3, -0.2, 0.1}, 0.1});
      }
      // with frames or without, before the last exposure and after
      ASSERT_NEAR(simulator.truth().t_s, std::floor(k * slice_s / 0.002 + 1e-6) * 0.002, 1e-9);
    }
    run.state_hash = simulator.state_hash(), run.image_hash = simulator.image_hash();
    EXPECT_EQ(run.images.size(), whole.images.size());
    EXPECT_TRUE(run == whole) << slice_s;
    EXPECT_EQ(simulator.timing().physics_s.size(), whole.images.size());
  }
}

TEST(Simulator, EachFrameComesItsLatencyAfterItsExposure) {
  for (const double rate_hz : {20.0, 30.0, 7.3}) {
    for (const double latency_s : {0.0, 0.05, 0.0133, 0.31}) {
      SimulatorParameters p = Hover();
      p.camera = vision::Pinhole{16, 16, 20, 20, 7.5, 7.5};
      p.start.settle_s = 0;
      p.image.rate_hz = rate_hz, p.image.latency_s = latency_s;
      Simulator simulator(p);
      int k = 0;
      for (; const auto frame = simulator.Next(); ++k) {
        const double due_s = k / rate_hz;
        EXPECT_EQ(frame->sequence, k);
        EXPECT_EQ(frame->t_s, simulator.exposure().t_s);
        EXPECT_NEAR(frame->t_s, due_s, 0.001 + 1e-9);  // to the nearest step of 2 ms
        EXPECT_NEAR(simulator.truth().t_s, due_s + latency_s, 0.001 + 1e-9);
        EXPECT_NEAR(simulator.State().t_s, simulator.truth().t_s, 1e-9);
      }
      EXPECT_EQ(k, static_cast<int>(std::floor(p.duration_s * rate_hz)) + 1) << rate_hz << ' ' << latency_s;
      EXPECT_FALSE(simulator.Next());  // and it stays at its end
    }
  }
}

TEST(Simulator, WhatIsExposedDoesNotDependOnTheLatency) {
  SimulatorParameters p = Hover();
  p.image.latency_s = 0;
  Simulator at_once(p);
  p.image.latency_s = 0.12;
  Simulator late(p);
  int frames = 0;
  for (;; ++frames) {
    const auto a = at_once.Next(), b = late.Next();
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) break;
    EXPECT_EQ(at_once.truth().X_NB.p, late.exposure().X_NB.p);
    EXPECT_EQ(at_once.exposure().X_NB.R.coeffs(), late.exposure().X_NB.R.coeffs());
    EXPECT_GT(late.truth().t_s, late.exposure().t_s);
    EXPECT_TRUE(Same(a->image, b->image));
  }
  EXPECT_EQ(frames, 11);
}

TEST(Simulator, TheSameSeedGivesTheSameStatesAndImages) {
  const Flown first = Fly(Hover()), again = Fly(Hover());
  EXPECT_TRUE(first == again);
  ASSERT_EQ(first.images.size(), 11u);
  for (std::size_t i = 0; i < first.images.size(); ++i) EXPECT_TRUE(Same(first.images[i], again.images[i]));
  SimulatorParameters p = Hover();
  p.seed = 2;
  const Flown other = Fly(p);
  EXPECT_NE(other.state_hash, first.state_hash);
  EXPECT_NE(other.image_hash, first.image_hash);
}

TEST(Simulator, ABusyMachineChangesNothing) {
  const Flown alone = Fly(Hover());
  std::atomic<bool> stop = false;
  std::vector<std::thread> busy;
  for (int i = 0; i < 3; ++i) {
    busy.emplace_back([&] {
      double x = 1;
      while (!stop) x = std::sin(x) + 1;
    });
  }
  const Flown crowded = Fly(Hover());
  stop = true;
  for (std::thread& t : busy) t.join();
  EXPECT_TRUE(crowded == alone);
}

TEST(Simulator, TwoAtOnceDoNotDisturbEachOther) {
  SimulatorParameters p = Hover(), q = Hover();
  q.seed = 5;
  const Flown p_alone = Fly(p), q_alone = Fly(q);
  Flown p_beside, q_beside;
  std::thread one([&] { p_beside = Fly(p); });
  std::thread two([&] { q_beside = Fly(q); });
  one.join();
  two.join();
  EXPECT_TRUE(p_beside == p_alone);
  EXPECT_TRUE(q_beside == q_alone);
}

TEST(Simulator, TheNumberOfDrawingThreadsChangesNothing) {
  SimulatorParameters p = Hover();
  p.duration_s = 0.2;
  p.render.backend = "osmesa";  // which reads this variable
  std::vector<Flown> runs;
  for (const char* threads : {"0", "1", "5"}) {
    setenv("LP_NUM_THREADS", threads, 1);
    runs.push_back(Fly(p));
  }
  unsetenv("LP_NUM_THREADS");
  EXPECT_TRUE(runs[0] == runs[1]);
  EXPECT_TRUE(runs[0] == runs[2]);
}

TEST(Simulator, ImagesAreTheSameDrawnBesideTheFlightOrInIt) {
  SimulatorParameters p = Hover();
  p.image.auto_exposure.target_grey = 40;  // an image depends on the one before
  const Flown beside = Fly(p);
  p.draw_beside = false;
  EXPECT_TRUE(Fly(p) == beside);
}

TEST(Simulator, WhatOneConsumerDrawsDoesNotShiftAnother) {
  const Flown usual = Fly(Hover());
  SimulatorParameters camera = Hover();
  camera.image.noise_grey = 9, camera.image.colour = true,
  camera.camera = vision::Pinhole{64, 48, 81, 81, 31.5, 23.5};
  EXPECT_EQ(Fly(camera).state_hash, usual.state_hash);  // what the camera draws

  // what the sensors draw does not change the gusts, though the aircraft flies a little differently
  SimulatorParameters gusty = Hover();
  gusty.wind.turbulence = false, gusty.wind.gusts = {60, 4, 1}, gusty.duration_s = 3, gusty.image.rate_hz = 5;
  SimulatorParameters sensors = gusty;
  sensors.sensors.gps_rate_hz = 10, sensors.sensors.gyro_noise_rad_s_rthz *= 10;
  const Flown a = Fly(gusty), b = Fly(sensors);
  EXPECT_NE(a.state_hash, b.state_hash);
  ASSERT_EQ(a.exposures.size(), b.exposures.size());
  double strongest = 0;
  for (std::size_t i = 0; i < a.exposures.size(); ++i) {
    EXPECT_EQ(a.exposures[i].wind_N, b.exposures[i].wind_N);
    strongest = std::max(strongest, (a.exposures[i].wind_N - a.exposures[0].wind_N).norm());
  }
  EXPECT_GT(strongest, 0.5);  // there were gusts
}

TEST(Simulator, StartsWhereItIsTold) {
  SimulatorParameters p = Hover();
  p.scene.pad_position_m = {20, -30}, p.scene.pad_yaw_deg = 70;
  p.start.offset_m = {0.7, -1.1}, p.start.height_m = 3.5, p.start.yaw_deg = 40, p.start.settle_s = 0;
  const Simulator simulator(p);
  const Truth& truth = simulator.truth();
  EXPECT_LT((truth.X_NT.p - Vector3d(20, -30, -0.01)).norm(), 1e-9);
  EXPECT_NEAR(Degrees(YawOf(truth.X_NT.R)), 70, 1e-9);
  // from the pad, northwards and eastwards whatever the pad's yaw
  EXPECT_LT((truth.X_NB.p - truth.X_NT.p - Vector3d(0.7, -1.1, -3.5)).norm(), 1e-9);
  EXPECT_NEAR(Degrees(YawOf(truth.X_NB.R)), 40, 1e-9);
  EXPECT_NEAR(Degrees(YawOf(simulator.State().R_NB)), 40, 1e-9);
  EXPECT_EQ(simulator.State().mode, control::FlightMode::kPosition);
}

TEST(Simulator, ScattersItsStartBySeedWithinItsBounds) {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{16, 16, 20, 20, 7.5, 7.5};
  p.start.settle_s = 0, p.start.scatter_m = 2, p.start.yaw_scatter_deg = 15, p.start.yaw_deg = 30;
  double farthest = 0, min_yaw = 90, max_yaw = -90;
  Vector2d sum = Vector2d::Zero();
  constexpr int kSeeds = 15;
  for (p.seed = 1; p.seed <= kSeeds; ++p.seed) {
    const Simulator simulator(p);
    const Pose& X_NB = simulator.truth().X_NB;
    farthest = std::max(farthest, X_NB.p.head<2>().norm());
    min_yaw = std::min(min_yaw, Degrees(YawOf(X_NB.R)));
    max_yaw = std::max(max_yaw, Degrees(YawOf(X_NB.R)));
    sum += X_NB.p.head<2>() / kSeeds;
  }
  EXPECT_LE(farthest, 2);
  EXPECT_GT(farthest, 1.5);
  EXPECT_LT(sum.norm(), 0.8);
  EXPECT_GE(min_yaw, 15);
  EXPECT_LT(min_yaw, 22);
  EXPECT_LE(max_yaw, 45);
  EXPECT_GT(max_yaw, 38);
}

TEST(Simulator, SettlesBeforeItsClockIsZero) {
  SimulatorParameters p = Hover();
  p.start.settle_s = 15;
  Simulator simulator(p);
  EXPECT_EQ(simulator.truth().t_s, 0);
  EXPECT_NEAR(simulator.State().t_s, 0, 1e-9);
  // it hovers in a wind of 3 m/s: it leans, by what GPS and wind leave it
  EXPECT_GT((simulator.truth().X_NB.R * Vector3d::UnitZ()).head<2>().norm(), 0.005);
  EXPECT_LT(simulator.truth().v_N.norm(), 1);
  EXPECT_LT(simulator.truth().X_NB.p.head<2>().norm(), 5);
  EXPECT_FALSE(simulator.touch());
}

TEST(Simulator, OnTheGroundItStandsOnItsSkids) {
  SimulatorParameters p = Hover();
  p.start.on_ground = true, p.start.yaw_deg = 25, p.start.settle_s = 2, p.duration_s = 1;
  Simulator simulator(p);
  while (simulator.Next()) {
    const Truth& truth = simulator.truth();
    EXPECT_TRUE(truth.touching);
    EXPECT_NEAR(truth.X_NT.p.z() - truth.X_NB.p.z(), 0.16, 0.01);
    EXPECT_LT(truth.X_NB.p.head<2>().norm(), 0.01);
    EXPECT_LT(truth.v_N.norm(), 0.02);
    EXPECT_GT((truth.X_NB.R * Vector3d::UnitZ()).z(), std::cos(Radians(0.5)));
    EXPECT_TRUE(simulator.State().landed);
  }
  EXPECT_FALSE(simulator.touch());  // it has not landed: it never flew
}

TEST(Simulator, TellsTheInstantBeforeTheTouchDown) {
  SimulatorParameters p = Hover();
  p.wind = {};
  p.start.height_m = 0.8, p.duration_s = 5;
  p.image.latency_s = 0;
  Simulator simulator(p);
  while (simulator.Next() && !simulator.truth().touching) {
    EXPECT_FALSE(simulator.touch());
    simulator.Send(control::VelocitySetpoint{{0, 0, 0.3}, 0});
  }
  ASSERT_TRUE(simulator.touch());
  const Truth& touch = *simulator.touch();
  EXPECT_FALSE(touch.touching);
  EXPECT_LE(touch.t_s, simulator.truth().t_s);
  EXPECT_GT(touch.t_s, simulator.truth().t_s - 0.051);
  EXPECT_NEAR(touch.X_NT.p.z() - touch.X_NB.p.z(), 0.16, 0.01);
  EXPECT_NEAR(touch.v_N.z(), 0.3, 0.15);
}

TEST(Simulator, TheSheetCoversThePadForItsTime) {
  SimulatorParameters p = Hover();
  p.occlusion = {1, 0.2, 0.35};
  const Flown covered = Fly(p);
  p.occlusion.from_s = 100;
  const Flown clear = Fly(p);
  EXPECT_EQ(covered.state_hash, clear.state_hash);  // it is only seen
  ASSERT_EQ(covered.images.size(), clear.images.size());
  int hidden = 0;
  for (std::size_t i = 0; i < clear.images.size(); ++i) {
    const double t = clear.exposures[i].t_s;
    const bool same = Same(covered.images[i], clear.images[i]);
    EXPECT_EQ(same, t < 0.2 - 1e-9 || t >= 0.35 - 1e-9) << t;
    hidden += !same;
  }
  EXPECT_EQ(hidden, 3);
}

TEST(Simulator, TheMountTurnsTheCameraInTheAircraft) {
  const auto axes = [](double yaw, double pitch, double roll) {
    return vision::MountPose({{0.1, 0.2, 0.3}, yaw, pitch, roll}).R.toRotationMatrix();
  };
  const auto near = [](const Vector3d& a, const Vector3d& b) { return (a - b).norm() < 1e-12; };
  const Vector3d forward(1, 0, 0), right(0, 1, 0), down(0, 0, 1);
  EXPECT_TRUE(near(axes(0, 0, 0).col(2), down));
  EXPECT_TRUE(near(-axes(0, 0, 0).col(1), forward));  // the top of the image
  EXPECT_TRUE(near(axes(0, 0, 0).col(0), right));
  EXPECT_TRUE(near(-axes(90, 0, 0).col(1), right));
  EXPECT_TRUE(near(axes(0, 90, 0).col(2), forward));  // nose up: it looks ahead
  EXPECT_TRUE(near(axes(0, 0, 90).col(2), -right));   // right side down: it looks to the left
  EXPECT_TRUE(near(vision::MountPose({{0.1, 0.2, 0.3}, 1, 2, 3}).p, {0.1, 0.2, 0.3}));
}

TEST(Simulator, TheCameraSeesThePadWhereTheTruthSaysItIs) {
  for (const vision::CameraMount& mount :
       {vision::CameraMount{}, vision::CameraMount{{0.12, -0.08, 0.03}, 35, 6, -9}}) {
    SimulatorParameters p = Hover();
    p.camera = vision::Pinhole{640, 480, 810.81, 810.81, 319.5, 239.5};
    p.mount = mount;
    p.scene.pad_position_m = {5, -7}, p.scene.pad_yaw_deg = 15;
    p.start.offset_m = {0.45, -0.3}, p.start.yaw_deg = 40, p.start.height_m = 4;
    p.duration_s = 0.1;
    Simulator simulator(p);
    const cv::Mat picture = cv::imread(p.scene.pad_texture.string(), cv::IMREAD_GRAYSCALE);
    vision::PadTracker tracker(vision::MakePadReference(picture, 1.19, 0.91),
                               std::get<vision::Pinhole>(p.camera), {});
    int seen = 0;
    while (const auto frame = simulator.Next()) {
      const auto observation = tracker.Track(frame->image, std::nullopt);
      if (!observation) continue;
      ++seen;
      const Truth& truth = simulator.exposure();
      const Pose X_CT = (truth.X_NB * simulator.X_BC()).Inverse() * truth.X_NT;
      EXPECT_LT((observation->X_CT.p - X_CT.p).norm(), 0.03);
      EXPECT_LT(Degrees(observation->X_CT.R.angularDistance(X_CT.R)), 1);
      EXPECT_GT(X_CT.p.head<2>().norm(), 0.2);  // off the axis, so that a mirrored image fails
    }
    EXPECT_EQ(seen, 3);
  }
}

TEST(Simulator, AMountAboveOrBelowTheAircraftShowsItsOwnParts) {
  SimulatorParameters p = Hover();
  const ModelPtr model = MakeModel(p.scene);
  const DataPtr data = MakeData(model.get());
  const Pose X_NB{Eigen::Quaterniond::Identity(), {0, 0, -5}};
  PoseToMujoco(X_NB, data->qpos);
  mj_forward(model.get(), data.get());
  Renderer renderer(model.get(), p.camera, p.render);
  const int vehicle = mj_name2id(model.get(), mjOBJ_BODY, "vehicle");
  const auto own_share = [&](const vision::CameraMount& mount) {
    const cv::Mat geom = renderer.Trace(data.get(), X_NB * vision::MountPose(mount)).geom;
    int own = 0;
    for (int y = 0; y < geom.rows; ++y) {
      for (int x = 0; x < geom.cols; ++x) {
        const int g = geom.at<int>(y, x);
        own += g >= 0 && model->geom_bodyid[g] == vehicle;
      }
    }
    return own / static_cast<double>(geom.total());
  };
  EXPECT_GT(own_share({{0, 0, -0.6}, 0, 0, 0}), 0.15);   // above, looking down
  EXPECT_GT(own_share({{0, 0, 0.6}, 0, 0, 180}), 0.15);  // below, looking up
  EXPECT_EQ(own_share({}), 0);
}

TEST(Simulator, AStateThatIsNoNumberEndsTheRun) {
  mju_user_warning = [](const char*) {};
  Simulator simulator(Hover());
  simulator.Send(control::AttitudeSetpoint{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0.5});
  try {
    while (simulator.Next()) {}
    ADD_FAILURE() << "nothing was thrown";
  } catch (const RunError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("not a number"));
    EXPECT_THAT(e.what(), ::testing::StartsWith("at 0.0"));
  }
  mju_user_warning = nullptr;
}

}  // namespace
}  // namespace kestrel::sim
