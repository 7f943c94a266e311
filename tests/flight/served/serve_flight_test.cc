// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_flight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>

#include "base/real_time.h"
#include "records/summary.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

LoadedScenario Short(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"duration_s=0.6", "start.settle_s=0.5", "seed=5"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return LoadScenario("landing", overrides);
}

// Time that passes only when it is slept through, or spent by hand.
struct FakeClock {
  double now_s = 500;
  WallClock Clock() {
    return {[this] { return now_s; }, [this](double t_s) { now_s = std::max(now_s, t_s); }};
  }
};

class FakeServer final : public sim::AutopilotServer {
 public:
  void Serve(double now_s, control::Autopilot& aircraft) override {
    calls.push_back({now_s, aircraft.State().t_s});
    if (!sends || !pilot) return;
    aircraft.Send(*sends);
    if (!counts_each && heard.setpoints > 0) return;
    ++heard.setpoints, ++heard.followed;
  }
  void SetPilot(bool allows) override { pilot = allows, switched_at_call = calls.size(); }
  const sim::WireCounts& Received() const override { return heard; }
  std::string Where() const override { return "udp://127.0.0.1:1"; }

  struct Call {
    double now_s, t_s;
  };
  std::vector<Call> calls;
  std::optional<control::Setpoint> sends;
  bool counts_each = true;  // otherwise it came once and is followed on
  sim::WireCounts heard;
  bool pilot = true;
  std::size_t switched_at_call = 0;
};

class ServeFlightTest : public InTemporaryFolder {
 protected:
  std::string Content(const char* file) const {
    std::ifstream in(folder_ / file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
};

TEST_F(ServeFlightTest, InRealTimeServersAreServedAndFramesComeWhenTheyAreDue) {
  const LoadedScenario loaded = Short();
  FakeServer server;
  server.sends = control::VelocitySetpoint{{0.5, 0, 0}, 0};
  const WallClock real = MonotonicClock();
  double begun_s = 0;
  std::vector<double> exposed_s, published_s;
  ServeOptions options;
  options.servers = {&server};
  options.begun = [&] { begun_s = real.now_s(); };
  options.publish = [&](const vision::Frame& frame) {
    exposed_s.push_back(frame.t_s), published_s.push_back(real.now_s() - begun_s);
  };
  const FlightResult result = ServeFlight(loaded, options);
  EXPECT_EQ(result.summary.error, "");
  EXPECT_EQ(result.summary.outcome, "completed");
  ASSERT_EQ(exposed_s.size(), 13u);
  for (std::size_t i = 0; i < exposed_s.size(); ++i) {
    EXPECT_NEAR(exposed_s[i], 0.05 * static_cast<double>(i), 1e-9);
    // Its latency after its exposure, never before; how much later is the machine's affair.
    EXPECT_GE(published_s[i], exposed_s[i] + loaded.scenario.image.latency_s - 0.003);
  }
  EXPECT_GE(result.summary.wall_s, 0.64);
  // each step of the world is one that the server sees, unless the machine is late
  ASSERT_GT(server.calls.size(), 200u);
  for (std::size_t i = 1; i < server.calls.size(); ++i) {
    EXPECT_GE(server.calls[i].now_s, server.calls[i - 1].now_s);
    EXPECT_GE(server.calls[i].t_s, server.calls[i - 1].t_s);
    EXPECT_LE(server.calls[i].t_s, server.calls[i - 1].t_s + 0.0021);
  }
  // by the simulator's own clock
  EXPECT_NEAR(server.calls.back().t_s, result.summary.sim_s, 1e-9);
  EXPECT_NEAR(result.summary.sim_s, 0.65, 1e-9);
  // and what it sent was flown
  EXPECT_EQ(result.summary.metrics.at("setpoints_heard"), static_cast<double>(server.calls.size()));
  EXPECT_GT(result.rows.back().now.v_N.head<2>().norm(), 0.1);
  ASSERT_TRUE(result.rows.back().decision.setpoint);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(*result.rows.back().decision.setpoint).v_H.x(), 0.5);
}

TEST_F(ServeFlightTest, WithoutAClientItIsTheSimulatorsOwnFlightToTheBit) {
  const LoadedScenario loaded = Short();
  sim::Simulator alone(loaded.simulator);
  while (alone.Next()) {}
  FakeClock clock;
  ServeOptions options;
  options.clock = clock.Clock();
  const records::Summary served = ServeFlight(loaded, options).summary;
  EXPECT_EQ(served.state_hash, alone.state_hash());
  EXPECT_EQ(served.image_hash, alone.image_hash());
  EXPECT_NEAR(clock.now_s, 500 + 0.65, 0.01);  // and took its time
}

TEST_F(ServeFlightTest, ATooSlowMachineStretchesTimeAndSaysSo) {
  FakeClock clock;
  FakeServer server;
  std::vector<std::string> said;
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  options.folder = folder_ / "run";
  options.publish = [&](const vision::Frame&) { clock.now_s += 0.25; };  // where 0.05 were right
  options.say = [&](const std::string& line) { said.push_back(line); };
  const FlightResult result = ServeFlight(Short(), options);
  EXPECT_EQ(result.rows.size(), 13u);  // nothing is skipped
  for (std::size_t i = 1; i < server.calls.size(); ++i)
    EXPECT_LE(server.calls[i].t_s, server.calls[i - 1].t_s + 0.0021);
  const double stretched_s = result.summary.metrics.at("stretched_s");
  // what each frame but the last costs too much; the last one's is after the end
  EXPECT_NEAR(stretched_s, 12 * (0.25 - 0.05), RealTime::kCatchUp_s + 0.01);
  EXPECT_NEAR(clock.now_s - 500, 0.65 + stretched_s + 0.25, RealTime::kCatchUp_s + 0.01);
  EXPECT_THAT(said, Contains(HasSubstr("the machine is too slow")));
  // once a second, and once at the end
  EXPECT_LE(static_cast<double>(said.size()), clock.now_s - 500 + 2);
  EXPECT_THAT(Content("run/events.log"), HasSubstr("the machine is too slow"));
  EXPECT_NEAR(records::ReadSummary(folder_ / "run/summary.json").metrics.at("stretched_s"), stretched_s,
              1e-6);
}

TEST_F(ServeFlightTest, ALandingIsJudgedByTheTruthAndEndsWhenItHasStood) {
  FakeClock clock;
  FakeServer server;
  server.sends = control::VelocitySetpoint{{0, 0, 0.4}, 0};
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  options.folder = folder_ / "run";
  const FlightResult result = ServeFlight(
      Short({"duration_s=30", "start.height_m=0.8", "start.scatter_m=0.01", "wind.mean_m_s=0",
             "wind.turbulence=false", "wind.gusts.rate_per_min=0", "criteria.fix_share={min: 0.5}"}),
      options);
  const records::Summary& s = result.summary;
  EXPECT_EQ(s.outcome, "landed");
  EXPECT_TRUE(s.complete);
  ASSERT_TRUE(s.metrics.contains("touchdown_error_m"));
  const Truth& end = result.rows.back().now;
  EXPECT_NEAR(s.metrics.at("touchdown_error_m"), (end.X_NB.p - end.X_NT.p).head<2>().norm(), 0.1);
  EXPECT_GT(s.metrics.at("touchdown_sink_m_s"), 0.1);
  EXPECT_TRUE(s.metrics.contains("rest_error_m"));
  EXPECT_LT(s.sim_s, 20);
  EXPECT_GT(s.sim_s, s.metrics.at("touchdown_s") + 3);
  EXPECT_FALSE(s.metrics.contains("fix_share"));
  for (const records::Criterion& c : s.criteria) EXPECT_NE(c.name, "fix_share");
  EXPECT_EQ(s.criteria.size(), 4u);
  EXPECT_THAT(Content("run/events.log"), HasSubstr("fix_share is left out"));
  EXPECT_THAT(Content("run/events.log"), HasSubstr("skids touch"));
  std::istringstream telemetry(Content("run/telemetry.csv"));
  std::string line;
  std::size_t lines = 0;
  while (std::getline(telemetry, line)) ++lines;
  EXPECT_EQ(lines, result.rows.size() + 1);
}

TEST_F(ServeFlightTest, WhoNeverTouchesDownHasNotMetTheCriteria) {
  FakeClock clock;
  ServeOptions options;
  options.clock = clock.Clock();
  const records::Summary s = ServeFlight(Short(), options).summary;
  EXPECT_TRUE(s.complete);
  EXPECT_FALSE(s.passed);
}

TEST_F(ServeFlightTest, ThePilotTakesTheAircraftAwayWhenHeIsTold) {
  FakeClock clock;
  FakeServer server;
  server.sends = control::VelocitySetpoint{};
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  options.pilot_off_at_s = 0.3;
  const records::Summary s = ServeFlight(Short(), options).summary;
  EXPECT_FALSE(server.pilot);
  ASSERT_LT(server.switched_at_call, server.calls.size());
  EXPECT_NEAR(server.calls[server.switched_at_call].t_s, 0.3, 0.0021);
  EXPECT_EQ(s.metrics.at("setpoints_heard"), static_cast<double>(server.switched_at_call));
}

TEST_F(ServeFlightTest, SetpointsThatAreNotNumbersDoNotReachTheAircraft) {
  FakeClock clock;
  FakeServer server;
  server.sends = control::VelocitySetpoint{{0, std::numeric_limits<double>::quiet_NaN(), 0}, 0};
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  const records::Summary s = ServeFlight(Short(), options).summary;
  EXPECT_EQ(s.error, "");
  EXPECT_TRUE(s.complete);
}

TEST_F(ServeFlightTest, WhatTheWireBroughtIsCountedOnceAndWhatIsNotHeededIsTold) {
  FakeClock clock;
  FakeServer server;
  server.sends = control::VelocitySetpoint{};
  server.counts_each = false;
  server.heard.refused = 2;
  server.heard.CountIgnored(sim::ignored::kImpossible, "TELEOP nan 0 0 0", 2);
  server.heard.CountIgnored(sim::ignored::kDamaged, "shorter than a header", 40000);
  std::vector<std::string> said;
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  options.folder = folder_ / "run";
  options.say = [&](const std::string& line) { said.push_back(line); };
  const records::Summary s = ServeFlight(Short(), options).summary;
  EXPECT_GT(server.calls.size(), 200u);
  EXPECT_EQ(s.metrics.at("setpoints_heard"), 1);
  EXPECT_EQ(s.metrics.at("setpoints_followed"), 1);
  EXPECT_EQ(s.metrics.at("setpoints_refused"), 2);
  EXPECT_EQ(s.metrics.at("messages_not_heeded"), 40002);
  const std::string events = Content("run/events.log");
  for (const char* line :
       {"ignored: damaged messages: shorter than a header", "ignored: 40000 damaged messages in all",
        "ignored: setpoints that cannot be followed: TELEOP nan 0 0 0"}) {
    EXPECT_THAT(events, HasSubstr(line));
    EXPECT_EQ(std::ranges::count_if(said, [&](const auto& each) { return each.ends_with(line); }), 1) << line;
  }
}

TEST_F(ServeFlightTest, AFlightThatNobodyFlewHasMetNothing) {
  FakeClock clock;
  FakeServer server;  // a client is there, and its switch is off
  server.heard.setpoints = 7;
  ServeOptions options;
  options.clock = clock.Clock();
  options.servers = {&server};
  const auto fly = [&](const std::vector<std::string>& more) {
    return ServeFlight(Short(more), options).summary;
  };
  // Of what is left out, all is met.
  const records::Summary left_out = fly({"criteria={fix_share: {min: 0.5}}"});
  EXPECT_EQ(left_out.outcome, "not flown");
  EXPECT_FALSE(left_out.passed);
  server.heard.followed = 1;
  EXPECT_TRUE(fly({"criteria={fix_share: {min: 0.5}}"}).passed);
  server.heard.followed = 0;
  const records::Summary nothing_to_judge = fly({"criteria={}"});
  EXPECT_EQ(nothing_to_judge.outcome, "completed");
  EXPECT_TRUE(nothing_to_judge.passed);
}

TEST_F(ServeFlightTest, AnInterruptEndsItInGoodOrder) {
  FakeClock clock;
  ServeOptions options;
  options.clock = clock.Clock();
  options.folder = folder_ / "run";
  options.go_on = [&] { return clock.now_s < 500.3; };
  const records::Summary s = ServeFlight(Short(), options).summary;
  EXPECT_EQ(s.outcome, "ended from outside");
  EXPECT_TRUE(s.complete);
  EXPECT_NEAR(s.sim_s, 0.3, 0.01);
  EXPECT_EQ(records::ReadSummary(folder_ / "run/summary.json").outcome, "ended from outside");
}

}  // namespace
}  // namespace kestrel::flight
