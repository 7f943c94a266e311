// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/serve_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>

#include "base/diagnostics.h"
#include "flight/simulated/scenario.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kNoScenario[] = "no_such_scenario";  // what else is wrong is told beside it, and at once

class At final : public sim::AutopilotServer {
 public:
  explicit At(std::string where) : where_(std::move(where)) {}
  void Serve(double, control::Autopilot&) override {}
  void SetPilot(bool) override {}
  const sim::WireCounts& Received() const override { return heard_; }
  std::string Where() const override { return where_; }

 private:
  std::string where_;
  sim::WireCounts heard_;
};

std::vector<flight::NamedServer> Servers(const std::string& name, const std::string& where) {
  std::vector<flight::NamedServer> servers;
  servers.push_back({name, std::make_unique<At>(where)});
  return servers;
}

ServeCommandArguments Parsed(std::vector<std::string> words) {
  CLI::App app;
  ServeCommandArguments arguments;
  AddServeCommand(app, arguments);
  words.insert(words.begin(), "serve");
  std::reverse(words.begin(), words.end());
  app.parse(words);
  return arguments;
}

TEST(ServeArguments, AfcsMayHaveAPlaceOfItsOwn) {
  EXPECT_FALSE(Parsed({"landing"}).afcs);
  EXPECT_EQ(Parsed({"landing", "--afcs"}).afcs, "");
  EXPECT_EQ(Parsed({"landing", "--afcs", "--asctec"}).afcs, "");
  EXPECT_EQ(Parsed({"landing", "--afcs", "127.0.0.1:2002"}).afcs, "127.0.0.1:2002");
  const ServeCommandArguments all =
      Parsed({"landing", "--mavlink", "px4", "--mavlink-port", "0", "--for", "2.5", "--pilot-off-at", "1",
              "--set", "seed=3", "--set", "duration_s=4"});
  EXPECT_EQ(all.mavlink, "px4");
  EXPECT_EQ(all.mavlink_port, 0);
  EXPECT_EQ(all.for_s, 2.5);
  EXPECT_EQ(all.pilot_off_at_s, 1);
  EXPECT_EQ(all.overrides.size(), 2u);
}

class ServeCommandTest : public InTemporaryFolder {
 protected:
  // What it is refused with; empty: it is not.
  std::string Refusal(ServeCommandArguments arguments) {
    if (arguments.scenario.empty()) arguments.scenario = "landing";
    arguments.out = folder_ / "run";
    try {
      ServeCommand(arguments);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
};

TEST_F(ServeCommandTest, AllMistakesAreToldAtOnce) {
  ServeCommandArguments a;
  a.camera = "rtp:5600 ! filesink", a.listen = "everywhere", a.afcs = "here:99999", a.mavlink_port = 14550;
  a.pilot_off_at_s = -1, a.seed = "x", a.for_s = std::nan(""), a.overrides = {"wind.mean_m_s=-3"};
  const std::string refusal = Refusal(a);
  for (const char* option : {"--camera", "--listen", "--afcs", "--mavlink-port", "--pilot-off-at", "--seed",
                             "--for: nan is out of range; valid: 0.1 to 36000 s", "wind.mean_m_s"})
    EXPECT_THAT(refusal, HasSubstr(option));
  EXPECT_THAT(refusal, Not(HasSubstr("duration_s")));
  a.scenario = kNoScenario;
  EXPECT_THAT(Refusal(a), AllOf(HasSubstr(kNoScenario), HasSubstr("--listen")));
}

TEST_F(ServeCommandTest, WhatIsOfRealTimeDoesNotGoWithLockstep) {
  ServeCommandArguments a =
      Parsed({"landing", "--lockstep", "tcp:0", "--afcs", "--camera", "rtp:5600", "--for", "5"});
  EXPECT_THAT(Refusal(a), HasSubstr("--lockstep: does not go with --afcs, --camera, --for: time waits"));
  a = Parsed({"landing", "--lockstep"});
  EXPECT_EQ(a.lockstep, "");
  a.lockstep = "tcp:70000";
  EXPECT_THAT(
      Refusal(a),
      HasSubstr("--lockstep: 'tcp:70000' has no port; valid: tcp:PORT, or the file of a Unix socket"));
  a.lockstep_timeout_s = -1;
  EXPECT_THAT(Refusal(a), HasSubstr("--lockstep-timeout: -1 is out of range"));
  a = Parsed({"landing", "--afcs", "127.0.0.1:0", "--once", "--no-video", "--lockstep-timeout", "3"});
  for (const char* option : {"--once", "--no-video", "--lockstep-timeout"})
    EXPECT_THAT(Refusal(a), HasSubstr(std::string(option) + ": means nothing without --lockstep"));
}

TEST_F(ServeCommandTest, HowLongMustBeATime) {
  ServeCommandArguments a;
  a.scenario = kNoScenario, a.afcs = "127.0.0.1:0";
  for (const double for_s : {0.0, -5.0, 1e300, std::numeric_limits<double>::infinity()}) {
    a.for_s = for_s;
    EXPECT_THAT(Refusal(a), HasSubstr("--for: ")) << for_s;
  }
}

TEST_F(ServeCommandTest, NoServerListensWhereTheStreamGoes) {
  ServeCommandArguments a;
  a.scenario = kNoScenario, a.camera = "rtp:14580", a.mavlink = "px4";
  EXPECT_THAT(Refusal(a), HasSubstr("--mavlink: port 14580 is where the camera's stream goes"));
  a.camera = "rtp:5600", a.mavlink_port = 5600;
  EXPECT_THAT(Refusal(a), HasSubstr("--mavlink-port: port 5600"));
  a.mavlink.reset(), a.mavlink_port.reset();
  a.afcs = "127.0.0.1:5600";
  EXPECT_THAT(Refusal(a), HasSubstr("--afcs: port 5600"));
  a.afcs.reset();
  a.physics = "ardupilot", a.physics_port = 5600;
  EXPECT_THAT(Refusal(a), HasSubstr("--physics-port: port 5600"));
}

TEST_F(ServeCommandTest, AFlightAtAnAutopilotsPaceIsNotSaidToBeInRealTime) {
  ServeCommandArguments a;
  a.scenario = "landing", a.physics = "px4", a.for_s = 30;
  const flight::LoadedScenario loaded = flight::LoadScenario("landing");
  EXPECT_THAT(flight::StartLines(a, loaded, {}, nullptr, "tcp://127.0.0.1:4560"),
              AllOf(HasSubstr("at the autopilot's pace"), HasSubstr("until 30 s are over"),
                    HasSubstr("tcp://127.0.0.1:4560, for px4"), HasSubstr("bin/px4\n"),
                    Not(HasSubstr("kestrel fly")), Not(HasSubstr("in real time"))));
  a.camera = "rtp:5600";
  EXPECT_THAT(flight::StartLines(a, loaded, {}, nullptr, "tcp://127.0.0.1:4560"),
              HasSubstr("kestrel fly landing --camera rtp://127.0.0.1:5600 --set-aircraft"));
}

TEST_F(ServeCommandTest, PhysicsThatNobodyFliesEndsWhenItsTimeIsOverAndHasMetNothing) {
  ServeCommandArguments a;
  a.scenario = "landing", a.physics = "px4", a.physics_port = 0, a.for_s = 0.2, a.out = folder_ / "run";
  testing::internal::CaptureStdout();
  EXPECT_EQ(ServeCommand(a), 1);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("waits for an autopilot"));
}

TEST_F(ServeCommandTest, AFlightThatNobodyFlewIsNotMet) {
  ServeCommandArguments a;
  a.scenario = "hover", a.afcs = "127.0.0.1:0", a.for_s = 0.6, a.out = folder_ / "run";
  testing::internal::CaptureStdout();
  EXPECT_EQ(ServeCommand(a), 1);
  EXPECT_THAT(
      testing::internal::GetCapturedStdout(),
      AllOf(HasSubstr("not flown"), HasSubstr("setpoints: 0 received"), Not(HasSubstr("touch-down"))));
}

TEST_F(ServeCommandTest, NothingToServeIsAMistake) {
  EXPECT_THAT(Refusal({}), HasSubstr("there is nothing to serve"));
}

TEST_F(ServeCommandTest, TheStartLinesSayHowToConnect) {
  ServeCommandArguments a;
  a.scenario = "landing", a.camera = "rtp:5600";
  const flight::LoadedScenario loaded = flight::LoadScenario("landing");
  const std::string lines = flight::StartLines(a, loaded, Servers("afcs", "udp://127.0.0.1:2002"), nullptr);
  EXPECT_THAT(lines, HasSubstr("SIMULATOR"));
  EXPECT_THAT(lines, HasSubstr("udp://127.0.0.1:2002"));
  EXPECT_THAT(lines, HasSubstr("kestrel fly landing --camera rtp://127.0.0.1:5600 "));
  EXPECT_THAT(lines, HasSubstr(" --autopilot afcs:udp://127.0.0.1:2002 --pilot-untold"));
  EXPECT_THAT(lines, HasSubstr("exposure_before_stamp_s: 0.05"));
  EXPECT_THAT(lines, Not(HasSubstr("WARNING")));
}

TEST_F(ServeCommandTest, WhatIsOpenBeyondThisComputerIsWarnedOf) {
  ServeCommandArguments a;
  a.scenario = "landing";
  const flight::LoadedScenario loaded = flight::LoadScenario("landing");
  const auto lines = [&](const char* where) {
    return flight::StartLines(a, loaded, Servers("x", where), nullptr);
  };
  EXPECT_THAT(lines("udp://0.0.0.0:14550"), HasSubstr("no authentication"));
  EXPECT_THAT(lines("udp://192.168.1.5:14550"), HasSubstr("no authentication"));
  EXPECT_THAT(lines("udp://[::]:14550"), HasSubstr("no authentication"));
  EXPECT_THAT(lines("udp://0.0.0.0:14550"), Not(HasSubstr("--autopilot x:udp://0.0.0.0")));
  EXPECT_THAT(lines("udp://[::]:14550"), Not(HasSubstr("--autopilot x:udp://[::]:")));
  EXPECT_THAT(lines("udp://[::1]:14550"), Not(HasSubstr("WARNING")));
  EXPECT_THAT(lines("serial:/dev/pts/3"), Not(HasSubstr("WARNING")));
  a.camera = "raw:192.168.1.5:5600";
  EXPECT_THAT(lines("serial:/dev/pts/3"), HasSubstr("no authentication"));
}

}  // namespace
}  // namespace kestrel::app
