// SPDX-License-Identifier: Apache-2.0
#include "control/link/asctec_link.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "tests/sim/server/asctec_line.h"

namespace kestrel::control {
namespace {

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Serves until something is so; in real time.
template <class Condition>
bool ServeUntil(sim::AscTecServer* server, Autopilot& aircraft, const Condition& condition) {
  for (const double end_s = Now_s() + 20; Now_s() < end_s;) {
    if (server) server->Serve(Now_s(), aircraft);
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}
std::string DeviceOf(const sim::AscTecServer& server) {
  return server.Where().substr(std::strlen("serial:"));
}

TEST(AscTecLink, HearsAndIsHeardOverAPseudoTerminal) {
  sim::AscTecServer server({});
  AscTecOptions options;
  options.device = DeviceOf(server);
  AscTecLink link(options);
  ScriptedAircraft aircraft;
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] { return link.Health().pilot_allows == true; }));
  aircraft.state = SomeState();
  ASSERT_TRUE(ServeUntil(&server, aircraft,
                         [&] { return link.State().R_NB.angularDistance(aircraft.state.R_NB) < 1e-3; }));
  EXPECT_TRUE(link.Health().open);
  EXPECT_GT(link.State().t_s, Now_s() - 5);
  EXPECT_LT(link.State().t_s, Now_s());
  link.Aid({});
  EXPECT_EQ(aircraft.aids, 0);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    link.Send(AttitudeSetpoint{0.1, 0.2, 0.3, 0.4});
    return aircraft.heard.size() >= 3;
  }));
  EXPECT_NEAR(LastOf<AttitudeSetpoint>(aircraft).thrust, 0.4, 1e-3);
  EXPECT_GE(link.Health().sent, 3u);
  EXPECT_EQ(server.counts().Refused(wire::LinkRefusal::kCheckSum), 0u);
}

TEST(AscTecLink, TwoDoNotCommandOneDevice) {
  sim::AscTecServer server({});
  AscTecOptions options;
  options.device = DeviceOf(server);
  ScriptedAircraft aircraft;
  auto first = std::make_unique<AscTecLink>(options);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] { return first->Health().pilot_allows == true; }));
  AscTecLink second(options);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    second.Send(AttitudeSetpoint{0, 0, 0, 1});
    return second.Health().error == options.device + ": in use by another program";
  }));
  // The first is not disturbed, and the second has said nothing.
  const std::uint64_t received = first->Health().received;
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    second.Send(AttitudeSetpoint{0, 0, 0, 1});
    return first->Health().received > received + 10;
  }));
  EXPECT_EQ(second.Health().received, 0u);
  EXPECT_TRUE(aircraft.heard.empty());
  first.reset();
  EXPECT_TRUE(ServeUntil(&server, aircraft, [&] { return second.Health().open; }));
}

TEST(AscTecLink, OpensTheDeviceAgainWhenTheFarEndComesBack) {
  const auto folder = std::filesystem::temp_directory_path() / ("kestrel_asctec_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto device = folder / "tty";
  AscTecOptions options;
  options.device = device;
  AscTecLink link(options);
  ScriptedAircraft aircraft;
  EXPECT_TRUE(ServeUntil(nullptr, aircraft, [&] {
    return !link.Health().open && link.Health().error.find(device) != std::string::npos;
  }));
  std::uint64_t received = 0;
  for (int time = 0; time < 2; ++time) {
    sim::AscTecServer server({});
    std::filesystem::create_symlink(DeviceOf(server), device);
    EXPECT_TRUE(ServeUntil(&server, aircraft, [&] { return link.Health().received > received + 5; }));
    EXPECT_TRUE(link.Health().open);
    received = link.Health().received;
    std::filesystem::remove(device);
  }
  EXPECT_TRUE(ServeUntil(nullptr, aircraft, [&] { return !link.Health().open; }));
  EXPECT_NE(link.Health().error, "");
  EXPECT_TRUE(link.Health().state_age_s);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kestrel::control
