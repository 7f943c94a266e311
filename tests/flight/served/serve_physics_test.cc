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
  std::optional<double> step_s() const override { return 0.001; }
  std::optional<sim::Actuation> Step(double dt_s, const sim::SensorReadings&, const Truth& truth) override {
    last_s = truth.t_s;
    last_dt_s = dt_s;
    if (last_s >= leaves_s_) return std::nullopt;
    return sim::Actuation{};
  }
  void Stop() override {}
  std::string Where() const override { return "udp://127.0.0.1:1"; }
  sim::PhysicsCounts counts() const override { return {}; }

  int begun = 0;
  double last_s = 0, last_dt_s = 0;

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
  EXPECT_EQ(peer.last_dt_s, 0.001);  // as it asked for
  EXPECT_GE(frames, 1);
}

TEST(ServePhysics, FaultsThatCannotReachTheAutopilotAreRefusedAllAtOnce) {
  const LoadedScenario loaded = LoadScenario(
      "hover",
      {"criteria={}",
       "sensors.faults=[{component: gps, type: off}, {component: gyro, type: stuck}, {component: baro, type: "
       "wrong}, {component: mag, type: off}, {component: mag, type: ok}]"});
  Mistakes of_ardupilot, of_px4;
  CheckPhysicsFaults("ardupilot", loaded, of_ardupilot);
  CheckPhysicsFaults("px4", loaded, of_px4);
  ASSERT_EQ(of_ardupilot.all().size(), 3U);
  EXPECT_EQ(of_ardupilot.all()[0].key, "sensors.faults.0.component");
  EXPECT_EQ(of_ardupilot.all()[1].key, "sensors.faults.2.component");
  EXPECT_EQ(of_ardupilot.all()[2].key, "sensors.faults.3.component");
  EXPECT_EQ(of_ardupilot.all()[0].what.substr(0, 4), "gps:");
  EXPECT_FALSE(of_ardupilot.all()[0].remedy.empty());
  EXPECT_TRUE(of_px4.empty());
}

TEST(ServePhysics, AFaultOfTheEmulatedAttitudeIsRefusedForBothAutopilots) {
  const LoadedScenario loaded =
      LoadScenario("hover", {"criteria={}", "sensors.attitude_faults=[{type: freeze}]"});
  for (const char* const kind : {"ardupilot", "px4"}) {
    Mistakes mistakes;
    CheckPhysicsFaults(kind, loaded, mistakes);
    ASSERT_EQ(mistakes.all().size(), 1U) << kind;
    EXPECT_EQ(mistakes.all()[0].key, "sensors.attitude_faults.0");
  }
}

}  // namespace
}  // namespace kestrel::flight
