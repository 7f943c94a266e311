// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/external_autopilot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/sim/on_ground.h"

namespace kestrel::sim {
namespace {

// Full thrust from a time on; the end at another.
class Jump final : public ExternalAutopilot {
 public:
  Jump(double from_s, double until_s) : from_s_(from_s), until_s_(until_s) {}
  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) override {
    times_s.push_back(truth.t_s);
    force_sum += readings.imu.specific_force_B.z() * dt_s;
    if (truth.t_s >= until_s_ - 1e-9) return std::nullopt;
    const double speed = truth.t_s >= from_s_ - 1e-9 ? 700 : 0;
    return RotorSpeeds{speed, speed, speed, speed};
  }
  std::vector<double> times_s;
  double force_sum = 0;  // m/s

 private:
  double from_s_, until_s_;
};

TEST(ExternalAutopilot, IsAskedAfterEachStepAndMovesTheRotorsAlone) {
  SimulatorParameters p = OnGround();
  Simulator simulator(p);
  Jump jump(0.5, 1.0);
  simulator.FlyBy(&jump);
  simulator.Send(
      control::PositionSetpoint{{0, 0, -5}, 0});  // to the emulated one, whose rotors these are no more
  std::vector<double> frames_s, heights_m;
  while (const auto frame = simulator.Next()) {
    frames_s.push_back(frame->t_s);
    heights_m.push_back(-simulator.exposure().X_NB.p.z());
    EXPECT_EQ(frame->t_s, simulator.exposure().t_s);
    const control::VehicleState state = simulator.State();
    EXPECT_EQ(state.landed, simulator.truth().touching);
    EXPECT_EQ(state.mode, state.landed ? control::FlightMode::kStopped : control::FlightMode::kHold);
    EXPECT_LT((state.p_NB - simulator.truth().X_NB.p).norm(), 1.5);  // an estimate, not nonsense
  }
  ASSERT_EQ(jump.times_s.size(), 500U);
  for (std::size_t i = 0; i < 500; ++i)
    EXPECT_NEAR(jump.times_s[i], 0.002 * static_cast<double>(i + 1), 1e-9);
  // Exposures at 0, 0.2, 0.4, 0.6 and 0.8 s, and the one at 1 s is never read out.
  ASSERT_EQ(frames_s.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(frames_s[k], 0.2 * static_cast<double>(k), 1e-9);
  EXPECT_NEAR(heights_m[2], heights_m[0], 1e-3);
  EXPECT_GT(heights_m[4], heights_m[2] + 0.1);
  EXPECT_FALSE(simulator.Next());  // it stays ended
  EXPECT_EQ(jump.times_s.size(), 500U);
  EXPECT_NEAR(simulator.truth().t_s, 1.0, 1e-9);
}

TEST(ExternalAutopilot, WhoDoesNotMoveTheRotorsChangesNothing) {
  SimulatorParameters p = OnGround();
  p.duration_s = 0.5;
  Simulator alone(p), watched(p);
  Jump nothing(100, 100);
  watched.FlyBy(&nothing);
  while (alone.Next()) EXPECT_TRUE(watched.Next());
  EXPECT_FALSE(watched.Next());
  EXPECT_EQ(alone.state_hash(), watched.state_hash());
  EXPECT_EQ(alone.image_hash(), watched.image_hash());
}

}  // namespace
}  // namespace kestrel::sim
