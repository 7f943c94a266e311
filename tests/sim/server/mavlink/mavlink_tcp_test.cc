// SPDX-License-Identifier: Apache-2.0
// The link by TCP, to the emulated vehicle behind a relay that is the server, as ArduPilot's SITL is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "base/diagnostics.h"
#include "control/link/mavlink_link.h"
#include "control/link/network_address.h"
#include "sim/server/mavlink/mavlink_server.h"
#include "tests/sim/server/fake_aircraft.h"

namespace kestrel::control {
namespace {

using boost::asio::ip::tcp;
using boost::asio::ip::udp;
using ::testing::HasSubstr;

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

sim::MavlinkServerOptions ArduPilot() {
  sim::MavlinkServerOptions options;
  options.dialect = "ardupilot", options.port = 0;
  return options;
}

// What goes to the client ends amidst a message, whenever it is looked at: the rest comes with the next.
class ServedByTcp {
 public:
  explicit ServedByTcp(std::uint16_t port = 0) { Listen(port); }
  void Listen(std::uint16_t port) {
    acceptor_.emplace(io_);
    acceptor_->open(tcp::v4());
    acceptor_->set_option(tcp::acceptor::reuse_address(true));
    acceptor_->bind({boost::asio::ip::address_v4::loopback(), port});
    acceptor_->listen();
    acceptor_->non_blocking(true);
    port_ = acceptor_->local_endpoint().port();
  }
  void Leave() { client_.reset(), kept_.clear(), ++left; }
  void GoAway() { Leave(), acceptor_.reset(); }
  std::uint16_t port() const { return port_; }
  std::string Where() const { return "tcp://127.0.0.1:" + std::to_string(port_); }

  bool Until(
      const std::function<bool()>& so, const std::function<void()>& each = [] {}) {
    for (const double end_s = Seconds() + 20; Seconds() < end_s;) {
      aircraft.state.t_s = Seconds() - begun_s_;
      server.Serve(Seconds(), aircraft);
      Pass();
      each();
      if (so()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  sim::MavlinkServer server{ArduPilot()};
  sim::FakeAircraft aircraft = sim::Flying(5);
  int left = 0;

 private:
  void Pass() {
    boost::system::error_code error;
    if (acceptor_) {
      tcp::socket came = acceptor_->accept(error);
      if (!error) client_.emplace(std::move(came)), client_->non_blocking(true);
    }
    if (!client_) return;
    std::array<std::uint8_t, 65536> buffer;
    const std::size_t size = client_->read_some(boost::asio::buffer(buffer), error);
    if (!error && size > 0) vehicle_.send_to(boost::asio::buffer(buffer, size), there_);
    for (;;) {
      const std::size_t told = vehicle_.receive(boost::asio::buffer(buffer), 0, error);
      if (error) break;
      kept_.insert(kept_.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(told));
    }
    constexpr std::size_t kHeldBack = 9;
    if (kept_.size() <= kHeldBack) return;
    const std::size_t passed =
        client_->write_some(boost::asio::buffer(kept_.data(), kept_.size() - kHeldBack), error);
    if (!error) kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(passed));
  }

  boost::asio::io_context io_;
  std::optional<tcp::acceptor> acceptor_;
  std::optional<tcp::socket> client_;
  udp::socket vehicle_ = [this] {
    udp::socket socket(io_, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
    socket.non_blocking(true);
    return socket;
  }();
  udp::endpoint there_{boost::asio::ip::address_v4::loopback(), ParseUdpAddress(server.Where()).port};
  std::vector<std::uint8_t> kept_;
  std::uint16_t port_ = 0;
  double begun_s_ = Seconds() - 100;
};

TEST(MavlinkLinkByTcp, FliesAServedAircraftThroughAStreamThatIsCutAnywhere) {
  ServedByTcp served;
  MavlinkLink link(served.Where(), {.take_control = true});
  EXPECT_EQ(link.Where(), served.Where());
  ASSERT_TRUE(served.Until([&] { return link.Health().state_age_s.has_value(); }));
  EXPECT_EQ(link.State().p_NB.z(), -5);
  const VelocitySetpoint setpoint{{1, 2, 3}, 0.25};
  ASSERT_TRUE(
      served.Until([&] { return link.State().mode == FlightMode::kVelocity; }, [&] { link.Send(setpoint); }));
  EXPECT_EQ(std::get<VelocitySetpoint>(served.aircraft.sent.back()).v_H, setpoint.v_H);
  const LinkHealth health = link.Health();
  EXPECT_TRUE(health.open);
  EXPECT_EQ(health.error, "");
  EXPECT_EQ(health.refused, 0u);  // no message was taken for two halves
  EXPECT_GT(health.received, 5u);
}

TEST(MavlinkLinkByTcp, AServerThatIsNotThereIsSaidSoAndWaitedFor) {
  ServedByTcp served;
  served.GoAway();
  const MavlinkLink link(served.Where(), {});
  ASSERT_TRUE(served.Until([&] { return link.Health().error.find("refused") != std::string::npos; }));
  EXPECT_THAT(link.Health().error, HasSubstr(served.Where() + ": "));
  EXPECT_THAT(link.Health().error, HasSubstr("tried again every second"));
  EXPECT_FALSE(link.Health().open);
  served.Listen(served.port());
  EXPECT_TRUE(served.Until([&] { return link.Health().state_age_s.has_value(); }));
}

TEST(MavlinkLinkByTcp, OneThatLeavesAmidstAMessageIsHeardAgainWhenItIsBack) {
  ServedByTcp served;
  const MavlinkLink link(served.Where(), {});
  ASSERT_TRUE(served.Until([&] { return link.Health().received > 30; }));
  served.Leave();
  std::string said;
  ASSERT_TRUE(served.Until([&] {
    said = link.Health().error;
    return said.find("the other end has closed the connection") != std::string::npos;
  }));
  served.aircraft.state.p_NB.x() = 7;
  ASSERT_TRUE(served.Until([&] { return link.State().p_NB.x() == 7; }));
  EXPECT_EQ(link.Health().error.find("tcp://"), std::string::npos);
  EXPECT_EQ(link.Health().refused, 0u);  // the half of before is not one with what came after
}

TEST(MavlinkLinkByTcp, AddressesThatCannotBeAreRefused) {
  EXPECT_THROW(MavlinkLink("tcp://127.0.0.1", {}), InputError);
  EXPECT_THROW(MavlinkLink("tcp://127.0.0.1:0", {}), InputError);
  EXPECT_THROW(MavlinkLink("tcp://:5760", {}), InputError);
}

}  // namespace
}  // namespace kestrel::control
