// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_physics.h"

#include <gtest/gtest.h>

#include <string>

namespace kestrel::flight {
namespace {

// Has one autopilot, which leaves at a time of its own.
class OnePeer final : public sim::PhysicsServer {
 public:
  explicit OnePeer(double leaves_s) : leaves_s_(leaves_s) {}
  bool Begin() override { return begun++ < 1 || last_s < leaves_s_; }
  std::optional<sim::Actuation> Step(double, const sim::SensorReadings&, const Truth& truth) override {
    last_s = truth.t_s;
    if (last_s >= leaves_s_) return std::nullopt;
    return sim::Actuation{};
  }
  void Stop() override {}
  std::string Where() const override { return "udp://127.0.0.1:1"; }
  sim::PhysicsCounts counts() const override { return {}; }

  int begun = 0;
  double last_s = 0;

 private:
  const double leaves_s_;
};

TEST(ServePhysics, AFlightLastsUntilItsAutopilotLeavesBeyondTheScenariosDuration) {
  const LoadedScenario loaded = LoadScenario("hover", {"criteria={}", "duration_s=0.2", "image.rate_hz=5",
                                                       "image.faults=[{type: intermittent, rate_per_min: 60, "
                                                       "length_s: 1, loss: 0.5}]"});
  OnePeer peer(1.5);
  int frames = 0, flights = 0;
  ServePhysics(
      loaded, peer, [&](const vision::Frame&) { ++frames; },
      [&](const std::string& line) { flights += line.find("an autopilot is there") != std::string::npos; });
  EXPECT_EQ(flights, 1);
  EXPECT_NEAR(peer.last_s, 1.5, 0.01);
  EXPECT_GE(frames, 1);
}

}  // namespace
}  // namespace kestrel::flight
