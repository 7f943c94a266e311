// SPDX-License-Identifier: Apache-2.0
// A deck that moves under the aircraft: what stands on it, and what the camera sees of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "sim/simulator.h"
#include "tests/sim/hover.h"
#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::sim {
namespace {

// Close above a deck that drives off some seconds later; it sinks onto it.
SimulatorParameters AboveADeck() {
  SimulatorParameters p = Hover();
  p.wind = {};
  p.scene.pad_height_m = 1;
  p.scene.deck.emplace();
  p.scene.deck->motion = "straight", p.scene.deck->speed_m_s = 4, p.scene.deck->starts_s = 3;
  p.autopilot.touch_down_lag_m_s = 0.5;
  p.start.height_m = 0.4;
  p.start.settle_s = 0.5;
  p.image.rate_hz = 20;
  p.duration_s = 9;
  return p;
}

// In the pad's frame, when the deck sets off and at the end.
struct Stood {
  Pose before, after;
  double speed_m_s = 0;  // of the aircraft, at the end
  bool landed = false;
};
Stood StandOn(const SimulatorParameters& p) {
  Simulator simulator(p);
  Stood stood;
  while (simulator.Next()) {
    simulator.Send(control::VelocitySetpoint{{0, 0, 0.8}, 0});
    const Truth& now = simulator.truth();
    const Pose X_TB = now.X_NT.Inverse() * now.X_NB;
    if (now.t_s < 3) stood.before = X_TB;
    stood.after = X_TB;
    stood.speed_m_s = now.v_N.norm();
    stood.landed = simulator.State().landed;
  }
  return stood;
}

TEST(SimulatorDeckTest, FrictionTakesAlongWhatStandsOnADeckThatDrivesOff) {
  const Stood stood = StandOn(AboveADeck());
  EXPECT_TRUE(stood.landed);
  EXPECT_NEAR(stood.speed_m_s, 4, 0.01);
  EXPECT_LT((stood.after.p - stood.before.p).norm(), 0.02);
}

TEST(SimulatorDeckTest, FromOneThatIsSlipperyItSlidesUnlessItIsFixed) {
  SimulatorParameters p = AboveADeck();
  p.scene.deck->friction = 0.05;
  EXPECT_GT((StandOn(p).after.p - StandOn(p).before.p).norm(), 0.3);
  p.scene.deck->hold = "fixed";
  const Stood stood = StandOn(p);
  EXPECT_LT((stood.after.p - stood.before.p).norm(), 0.005);
  EXPECT_NEAR(stood.speed_m_s, 4, 1e-6);
}

TEST(SimulatorDeckTest, StandsOnADeckInASeaAndItsAutopilotNotices) {
  SimulatorParameters p = AboveADeck();
  p.scene.deck->motion = "still";
  p.scene.deck->waves = WaveParameters{.spectrum = "bretschneider", .sea_state = 5, .from_deg = 40};
  p.start.height_m = 2.5;
  p.duration_s = 14;
  const Stood stood = StandOn(p);
  EXPECT_TRUE(stood.landed);
  EXPECT_NEAR(-stood.after.p.z(), 0.16, 0.01);
  EXPECT_LT(Degrees(std::acos((stood.after.R * Eigen::Vector3d::UnitZ()).z())), 1);
}

// Each picture shows the pad where it was in the middle of its exposure.
TEST(SimulatorDeckTest, EitherRendererShowsTheDeckWhereItIsAtTheExposure) {
  for (const char* backend : {"ray", "osmesa"}) {
    SimulatorParameters p = AboveADeck();
    p.render.backend = backend;
    p.scene.deck->speed_m_s = 6, p.scene.deck->starts_s = -10, p.scene.deck->acceleration_m_s2 = 10;
    p.scene.deck->motion = "circle", p.scene.deck->radius_m = 1.2;  // below the aircraft all the while
    p.scene.deck->speed_m_s = 3;
    p.scene.deck->waves = WaveParameters{.spectrum = "bretschneider", .sea_state = 6, .from_deg = 70};
    p.camera = vision::Pinhole{320, 240, 250, 250, 159.5, 119.5};
    p.start.height_m = 4, p.start.offset_m = {0, 1.2};
    p.image.noise_grey = 0;
    p.duration_s = 1;
    Simulator simulator(p);
    vision::PadTracker tracker(
        vision::MakePadReference(vision::PadPicture(), vision::kPadLength_m, vision::kPadWidth_m),
        std::get<vision::Pinhole>(p.camera), {});
    int seen = 0;
    while (const auto frame = simulator.Next()) {
      const auto pad = tracker.Track(frame->image, std::nullopt);
      simulator.Send(control::VelocitySetpoint{});
      if (!pad) continue;
      const Truth& at = simulator.exposure();
      const Pose X_CT = at.X_NC.Inverse() * at.X_NT;
      EXPECT_LT((pad->X_CT.p - X_CT.p).head<2>().norm(), 0.02)
          << backend << at.t_s;  // it moves 0.15 m in a frame
      ++seen;
    }
    EXPECT_GT(seen, 10) << backend;
  }
}

TEST(SimulatorDeckTest, TheTruthOfADeckHasItsVelocityAndTheSameSeedTheSameSea) {
  SimulatorParameters p = AboveADeck();
  p.start.height_m = 4;
  p.duration_s = 0.6;
  p.scene.deck->waves = WaveParameters{.spectrum = "jonswap", .sea_state = 4};
  const Watched first = Watch(p), second = Watch(p);
  EXPECT_EQ(first.state_hash, second.state_hash);
  EXPECT_EQ(first.image_hash, second.image_hash);
  p.seed = 2;
  EXPECT_NE(Watch(p).state_hash, first.state_hash);
  Simulator simulator(p);
  Truth before;
  int steps = 0;
  for (double t = 0.1; t < 0.5; t += 0.002, ++steps) {
    simulator.NextUntil(t);
    const Truth now = simulator.truth();
    if (const double dt_s = now.t_s - before.t_s; steps > 0 && dt_s > 0) {
      EXPECT_LT(((now.X_NT.p - before.X_NT.p) / dt_s - (now.v_NT + before.v_NT) / 2).norm(), 1e-3) << t;
    }
    before = now;
  }
}

}  // namespace
}  // namespace kestrel::sim
