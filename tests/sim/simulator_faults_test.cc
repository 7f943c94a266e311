// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstdint>
#include <map>
#include <string>

#include "tests/sim/hover.h"

namespace kestrel::sim {
namespace {

SimulatorParameters WithFault(const char* type, double from_s, double until_s) {
  SimulatorParameters p = Hover();
  p.camera = vision::Pinhole{48, 32, 60, 60, 23.5, 15.5};
  p.duration_s = 2;
  CameraFault f;
  f.type = type, f.from_s = from_s, f.until_s = until_s;
  p.image.faults = {f};
  return p;
}

Watched Healthy() {
  SimulatorParameters p = WithFault("off", 0, 1);
  p.image.faults.clear();
  return Watch(p);
}

// Frames by their numbers; nothing where one is missing.
std::map<std::int64_t, vision::Frame> ByNumber(const Watched& run) {
  std::map<std::int64_t, vision::Frame> frames;
  for (const vision::Frame& f : run.frames) frames[f.sequence] = f;
  EXPECT_EQ(frames.size(), run.frames.size());
  return frames;
}

TEST(SimulatorFaults, OffThereAreNoFramesAndTheirNumbersAreMissing) {
  const Watched run = Watch(WithFault("off", 0.5, 1.2)), healthy = Healthy();
  EXPECT_EQ(run.state_hash, healthy.state_hash);
  ASSERT_EQ(healthy.frames.size(), 41u);
  auto frames = ByNumber(run);
  for (const vision::Frame& f : healthy.frames) {
    const bool off = f.t_s > 0.499 && f.t_s < 1.199;
    ASSERT_EQ(frames.count(f.sequence), off ? 0u : 1u) << f.t_s;
    if (off) continue;
    EXPECT_EQ(frames[f.sequence].t_s, f.t_s);
    EXPECT_TRUE(Same(frames[f.sequence].image, f.image)) << f.t_s;
  }
  EXPECT_EQ(run.frames.size(), 27u);
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    EXPECT_NEAR(run.given_s[i] - run.frames[i].t_s, 0.05, 1e-9);
}

TEST(SimulatorFaults, OffToTheEndTheFlightGoesOnToItsEndAllTheSame) {
  for (const double from_s : {0.0, 0.5}) {
    const Watched run = Watch(WithFault("off", from_s, 1e9));
    EXPECT_EQ(run.frames.size(), from_s > 0 ? 10u : 0u);
    EXPECT_NEAR(run.end_s, 2, 1e-9);
    EXPECT_EQ(run.state_hash, Healthy().state_hash);
  }
}

TEST(SimulatorFaults, WhileItIsOffTheAutopilotHoldsOnceItsSetpointIsStale) {
  SimulatorParameters p = WithFault("off", 0.2, 6);
  p.wind = {};
  p.duration_s = 7;
  Simulator simulator(p);
  while (const auto frame = simulator.Next()) {
    if (frame->t_s < 0.2) {
      simulator.Send(control::VelocitySetpoint{{1, 0, 0}, 0});
    } else {
      EXPECT_NEAR(frame->t_s, 6, 1e-9);
      EXPECT_EQ(simulator.State().mode, control::FlightMode::kHold);
      EXPECT_LT(simulator.truth().v_N.norm(), 0.4);
      break;
    }
  }
}

TEST(SimulatorFaults, StuckTheImageStaysAndNumberAndTimeGoOn) {
  const Watched run = Watch(WithFault("stuck", 0.5, 1.2)), healthy = Healthy();
  EXPECT_EQ(run.state_hash, healthy.state_hash);
  ASSERT_EQ(run.frames.size(), healthy.frames.size());
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.frames[i].sequence, healthy.frames[i].sequence);
    EXPECT_EQ(run.frames[i].t_s, healthy.frames[i].t_s);
    const bool stuck = i >= 10 && i < 24;
    EXPECT_TRUE(Same(run.frames[i].image, healthy.frames[stuck ? 9 : i].image)) << i;
    EXPECT_EQ(stuck, !Same(run.frames[i].image, healthy.frames[i].image)) << i;
  }
  // A flight code that draws on a frame does not draw on the next.
  EXPECT_NE(run.frames[12].image.data, run.frames[13].image.data);
  const Watched from_the_start = Watch(WithFault("stuck", 0, 0.2));
  EXPECT_TRUE(Same(from_the_start.frames[0].image, healthy.frames[0].image));
  EXPECT_TRUE(Same(from_the_start.frames[3].image, healthy.frames[0].image));
  EXPECT_TRUE(Same(from_the_start.frames[4].image, healthy.frames[4].image));
}

TEST(SimulatorFaults, GarbageIsNoiseAndNumberAndTimeGoOn) {
  const Watched run = Watch(WithFault("garbage", 0.5, 1.2)), healthy = Healthy();
  ASSERT_EQ(run.frames.size(), healthy.frames.size());
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.frames[i].sequence, healthy.frames[i].sequence);
    EXPECT_EQ(run.frames[i].t_s, healthy.frames[i].t_s);
    EXPECT_EQ(run.frames[i].image.size(), healthy.frames[i].image.size());
    EXPECT_EQ(run.frames[i].image.type(), healthy.frames[i].image.type());
    const bool garbage = i >= 10 && i < 24;
    EXPECT_EQ(Same(run.frames[i].image, healthy.frames[i].image), !garbage) << i;
    if (!garbage) continue;
    cv::Scalar mean, deviation;
    cv::meanStdDev(run.frames[i].image, mean, deviation);
    EXPECT_NEAR(deviation[0], 74, 5);
  }
}

TEST(SimulatorFaults, SlowThereAreFewerFramesWithNumbersThatFollow) {
  SimulatorParameters p = WithFault("slow", 0.5, 1.5);
  p.image.faults[0].rate_hz = 4;
  const Watched run = Watch(p);
  EXPECT_EQ(run.state_hash, Healthy().state_hash);
  std::vector<double> within;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.frames[i].sequence, static_cast<std::int64_t>(i));
    const double t = run.frames[i].t_s;
    if (t > 0.499 && t < 1.499) within.push_back(t);
  }
  ASSERT_EQ(within.size(), 4u);  // the last frame before was at 0.45 s
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(within[i], 0.7 + 0.25 * static_cast<double>(i), 1e-9);
  EXPECT_EQ(run.frames.size(), 41u - 20 + 4);
}

TEST(SimulatorFaults, DelayedTheyComeLaterButInTheirOrder) {
  SimulatorParameters p = WithFault("delayed", 0.5, 1.2);
  p.image.faults[0].delay_s = 0.33;
  const Watched run = Watch(p), healthy = Healthy();
  EXPECT_EQ(run.state_hash, healthy.state_hash);
  EXPECT_EQ(run.image_hash, healthy.image_hash);  // the same images, in the same order
  ASSERT_EQ(run.frames.size(), healthy.frames.size());
  double latest_s = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const double t = run.frames[i].t_s;
    EXPECT_EQ(t, healthy.frames[i].t_s);
    const double due_s = t + 0.05 + (t > 0.499 && t < 1.199 ? 0.33 : 0);
    latest_s = std::max(latest_s, due_s);
    EXPECT_NEAR(run.given_s[i], latest_s, 0.0011) << i;
  }
  EXPECT_NEAR(run.given_s[24], 1.53, 0.0011);  // exposed at 1.2 s, given with the last of the late ones
}

TEST(SimulatorFaults, IntermittentSomeAreLostBySeed) {
  SimulatorParameters p = WithFault("intermittent", 0.5, 1.8);
  p.image.faults[0].loss = 0.5;
  const Watched run = Watch(p), again = Watch(p), healthy = Healthy();
  EXPECT_EQ(run.image_hash, again.image_hash);
  EXPECT_EQ(run.state_hash, healthy.state_hash);
  auto frames = ByNumber(run);
  int lost = 0;
  for (const vision::Frame& f : healthy.frames) {
    if (!frames.count(f.sequence)) {
      ++lost;
      EXPECT_GT(f.t_s, 0.499);
      EXPECT_LT(f.t_s, 1.799);
    } else {
      EXPECT_TRUE(Same(frames[f.sequence].image, f.image));
    }
  }
  EXPECT_GT(lost, 5);
  EXPECT_LT(lost, 21);
  std::vector<std::int64_t> numbers, others;
  p.seed = 9;
  for (const vision::Frame& f : run.frames) numbers.push_back(f.sequence);
  for (const vision::Frame& f : Watch(p).frames) others.push_back(f.sequence);
  EXPECT_NE(numbers, others);
}

TEST(SimulatorFaults, AreToldWithTheirTime) {
  SimulatorParameters p = WithFault("off", 0.333, 0.777);
  Simulator simulator(p);
  std::vector<std::string> told;
  while (const auto frame = simulator.Next()) {
    while (told.size() < simulator.camera_changes().size()) {
      const CameraCondition& c = simulator.camera_changes()[told.size()];
      EXPECT_LE(c.from_s, simulator.truth().t_s);
      told.push_back(c.name + " " + std::to_string(c.from_s));
    }
    EXPECT_EQ(told.size(), frame->t_s < 0.333 ? simulator.truth().t_s < 0.333 ? 0u : 1u : 2u) << frame->t_s;
  }
  EXPECT_THAT(told, ::testing::ElementsAre("off 0.333000", "ok 0.777000"));
}

}  // namespace
}  // namespace kestrel::sim
