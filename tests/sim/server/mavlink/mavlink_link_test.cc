// SPDX-License-Identifier: Apache-2.0
// The same two ends on sockets. What they say to each other is tested by mavlink_pair_test.cc.
#include "control/link/mavlink_link.h"

#include <gtest/gtest.h>

#include <boost/asio.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "base/diagnostics.h"
#include "control/link/network_address.h"
#include "sim/server/mavlink/mavlink_server.h"
#include "tests/sim/server/fake_aircraft.h"

namespace kestrel::control {
namespace {

using boost::asio::ip::udp;
using namespace wire::mavlink;

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Served {
  explicit Served(const sim::MavlinkServerOptions& options) : server(options) {}
  // Until it is so; false: it never was.
  bool Until(
      const std::function<bool()>& so, const std::function<void()>& each = [] {}, double max_s = 20) {
    for (const double end_s = Now_s() + max_s; Now_s() < end_s;) {
      aircraft.state.t_s = Now_s() - begun_s;
      server.Serve(Now_s(), aircraft);
      each();
      if (so()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  sim::MavlinkServer server;
  sim::FakeAircraft aircraft = sim::Flying(5);
  double begun_s = Now_s() - 100;
};

sim::MavlinkServerOptions Options(const char* dialect = "ardupilot") {
  sim::MavlinkServerOptions options;
  options.dialect = dialect, options.port = 0;
  return options;
}
const MavlinkOptions kTakes{.take_control = true};

class Stranger {
 public:
  explicit Stranger(const std::string& to) {
    const UdpAddress address = ParseUdpAddress(to);
    to_ = udp::endpoint(boost::asio::ip::make_address(address.host), address.port);
    socket_.non_blocking(true);
  }
  void Say(const Message& message) { socket_.send_to(boost::asio::buffer(sender_.Encode(message)), to_); }
  bool Received() {
    boost::system::error_code error;
    std::array<char, 300> buffer;
    socket_.receive(boost::asio::buffer(buffer), 0, error);
    return !error;
  }
  int Drain() {
    int count = 0;
    while (Received()) ++count;
    return count;
  }
  Sender sender_{1, 1};

 private:
  boost::asio::io_context context_;
  udp::socket socket_{context_, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0)};
  udp::endpoint to_;
};

TEST(MavlinkLink, FliesAServedAircraft) {
  Served served(Options());
  MavlinkLink link(served.server.Where(), kTakes);
  EXPECT_EQ(link.Where(), served.server.Where());
  EXPECT_EQ(link.State().t_s, 0);
  ASSERT_TRUE(served.Until([&] { return link.Health().state_age_s.has_value(); }));
  EXPECT_EQ(link.State().p_NB.z(), -5);
  EXPECT_LT(std::abs(Now_s() - link.State().t_s), 5);
  const VelocitySetpoint setpoint{{1, 2, 3}, 0.25};
  ASSERT_TRUE(served.Until([&] { return !served.aircraft.sent.empty(); }, [&] { link.Send(setpoint); }));
  EXPECT_EQ(std::get<VelocitySetpoint>(served.aircraft.sent.back()).v_H, setpoint.v_H);
  ASSERT_TRUE(
      served.Until([&] { return link.State().mode == FlightMode::kVelocity; }, [&] { link.Send(setpoint); }));
  EXPECT_TRUE(link.Health().open);
  EXPECT_EQ(link.Health().pilot_allows, true);
  EXPECT_EQ(link.Health().error, "");
  EXPECT_GT(link.Health().sent, 0U);
  link.Silence();
  served.server.SetPilot(false);
  ASSERT_TRUE(served.Until([&] { return link.Health().pilot_allows == false; }));
}

TEST(MavlinkLink, ListensForAnAutopilotThatTellsUnasked) {
  MavlinkLink link("udpin://127.0.0.1:0", {});
  const UdpAddress where = ParseUdpAddress(link.Where());
  EXPECT_GT(where.port, 0);
  sim::MavlinkServerOptions options = Options("px4");
  options.peer = ToText({false, where.host, where.port});
  Served served(options);
  EXPECT_EQ(link.Health().error, "no autopilot heard");
  ASSERT_TRUE(served.Until([&] { return link.Health().state_age_s.has_value(); }));
  // A stranger that speaks as the autopilot does, with times that would be the newest.
  Stranger stranger(ToText({false, where.host, where.port}));
  const std::uint64_t received = link.Health().received;
  ASSERT_TRUE(served.Until([&] { return link.Health().received > received + 60; },
                           [&] {
                             stranger.Say(
                                 Heartbeat{.custom_mode = kPx4.setpoint_mode, .type = 2, .autopilot = 12});
                             stranger.Say(LocalPositionNed{.time_boot_ms = 4000000, .x = 77});
                             EXPECT_EQ(link.State().p_NB.x(), 0);
                           }));
  EXPECT_NE(link.Health().pilot_allows, true);
  EXPECT_FALSE(stranger.Received());
}

TEST(MavlinkServer, TakesNothingFromAnAddressThatDidNotOpenTheSession) {
  Served served(Options());
  Stranger early(served.server.Where()), late(served.server.Where());
  early.Say(SetCustomMode(kArduPilot.setpoint_mode, kArduPilot, {}));  // is no heartbeat
  const auto tell = [](Stranger& stranger) {
    stranger.Say(CompanionHeartbeat());
    stranger.Say(SetCustomMode(kArduPilot.setpoint_mode, kArduPilot, {}));
    stranger.Say(ToMessage(VelocitySetpoint{{9, 0, 0}, 0}, 0, kArduPilot, {}, 0));
  };
  MavlinkLink link(served.server.Where(), {});
  ASSERT_TRUE(served.Until([&] { return link.Health().open; }));
  int times = 0;
  const double begun_s = Now_s();
  ASSERT_TRUE(served.Until([&] { return ++times > 50; }, [&] { tell(late); }));
  EXPECT_TRUE(served.aircraft.sent.empty());
  // It is told that it is refused, seldom, and nothing of the aircraft.
  ASSERT_TRUE(late.Received());
  EXPECT_LT(late.Drain(), 5 + (Now_s() - begun_s) / sim::MavlinkServer::kTellAgain_s);
  const auto& ignored = served.server.Received().ignored;
  EXPECT_GE(ignored.at(sim::ignored::kSecondClient).count, 50U);
  EXPECT_GE(ignored.at(sim::ignored::kNoSession).count, 100U);
  EXPECT_EQ(served.server.Received().setpoints, 0U);
  EXPECT_FALSE(early.Received());
  EXPECT_EQ(link.State().mode, FlightMode::kHold);
}

// At times that the test makes: two that would both fly the aircraft.
struct Contended {
  void Serve(double after_s) {
    now_s += after_s, aircraft.state.t_s += after_s;
    server.Serve(now_s, aircraft);
  }
  static void Fly(Stranger& by, double v_m_s) {
    by.Say(CompanionHeartbeat());
    by.Say(SetCustomMode(kArduPilot.setpoint_mode, kArduPilot, {}));
    by.Say(ToMessage(VelocitySetpoint{{v_m_s, 0, 0}, 0}, 0, kArduPilot, {}, 0));
  }
  // What the aircraft is told last; 0: to stand still, or nothing.
  double Told() const {
    return aircraft.sent.empty() ? 0 : std::get<VelocitySetpoint>(aircraft.sent.back()).v_H.x();
  }

  sim::MavlinkServer server{Options()};
  sim::FakeAircraft aircraft = sim::Flying(5);
  Stranger owner{server.Where()}, other{server.Where()};
  double now_s = 1000;
};

TEST(MavlinkServer, AFloodNeitherHidesTheOwnerNorTakesTheSession) {
  Contended c;
  Contended::Fly(c.owner, 1);
  c.Serve(0.5);
  for (int i = 0; i < 12; ++i) {
    for (int k = 0; k < 400; ++k) Contended::Fly(c.other, 9);  // more than a queue holds
    Contended::Fly(c.owner, 1);
    c.Serve(0.5);
    ASSERT_EQ(c.Told(), 1) << i;
  }
  EXPECT_EQ(c.server.Received().setpoints, 13U);
}

TEST(MavlinkServer, WhoSpokeInTimeAndWasReadLateKeepsTheSession) {
  Contended c;
  Contended::Fly(c.owner, 1);
  c.Serve(0.5);
  Contended::Fly(c.other, 9);
  Contended::Fly(c.owner, 2);
  c.Serve(10 * sim::MavlinkServer::kSilent_s);
  EXPECT_EQ(c.Told(), 2);
}

TEST(MavlinkServer, AnotherHasTheSessionOfAnOwnerWhoIsSilent) {
  Contended c;
  Contended::Fly(c.owner, 1);
  c.Serve(0.5);
  Contended::Fly(c.other, 9);
  c.Serve(sim::MavlinkServer::kSilent_s - 0.1);
  EXPECT_NE(c.Told(), 9);
  Contended::Fly(c.other, 9);
  c.Serve(0.2);
  EXPECT_EQ(c.Told(), 9);
  Contended::Fly(c.owner, 1);
  c.Serve(0.1);
  EXPECT_EQ(c.Told(), 9);
}

TEST(MavlinkLink, ASecondClientIsToldThatAnotherHasTheSession) {
  Served served(Options());
  MavlinkLink first(served.server.Where(), {});
  ASSERT_TRUE(served.Until([&] { return first.Health().open; }));
  MavlinkLink second(served.server.Where(), {});
  ASSERT_TRUE(served.Until(
      [&] { return second.Health().error.find("another client has the session") != std::string::npos; }));
  EXPECT_FALSE(second.Health().open);
  EXPECT_TRUE(first.Health().open);
}

TEST(MavlinkLink, AFarEndThatWasStartedAnewIsHeardAgain) {
  sim::MavlinkServerOptions options = Options();
  auto served = std::make_unique<Served>(options);
  options.port = ParseUdpAddress(served->server.Where()).port;
  MavlinkLink link(served->server.Where(), {});
  ASSERT_TRUE(served->Until([&] { return link.Health().state_age_s.has_value(); }));
  served.reset();
  served = std::make_unique<Served>(options);
  served->begun_s = Now_s();
  served->aircraft.state.p_NB.x() = 7;
  EXPECT_TRUE(served->Until([&] { return link.State().p_NB.x() == 7; }));
}

TEST(MavlinkLink, AddressesThatCannotBeAreRefused) {
  EXPECT_THROW(MavlinkLink("14540", {}), InputError);
  EXPECT_THROW(MavlinkLink("udpin://192.0.2.1:0", {}), InputError);  // is not this computer's
  const MavlinkLink link("udpin://127.0.0.1:0", {});
  EXPECT_THROW(MavlinkLink(link.Where(), {}), InputError);
  sim::MavlinkServerOptions options;
  options.port = ParseUdpAddress(link.Where()).port;
  EXPECT_THROW(sim::MavlinkServer{options}, InputError);
}

}  // namespace
}  // namespace kestrel::control
