// SPDX-License-Identifier: Apache-2.0
#include "control/link/tcp_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>

namespace kestrel::control {
namespace {

using boost::asio::ip::tcp;
using ::testing::HasSubstr;

constexpr auto kPatience = std::chrono::seconds(20);

// A server's end that is read and written by hand.
struct Server {
  explicit Server(boost::asio::io_context& io, std::uint16_t port = 0) : acceptor(io) {
    acceptor.open(tcp::v4());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.set_option(tcp::socket::receive_buffer_size(4096));
    acceptor.bind({boost::asio::ip::address_v4::loopback(), port});
    acceptor.listen();
    acceptor.non_blocking(true);
  }
  bool Accept() {
    boost::system::error_code error;
    tcp::socket socket = acceptor.accept(error);
    if (error) return false;
    peer.emplace(std::move(socket));
    peer->non_blocking(true);
    return true;
  }
  std::vector<std::uint8_t> Read() {
    std::vector<std::uint8_t> bytes(65536);
    boost::system::error_code error;
    bytes.resize(peer->read_some(boost::asio::buffer(bytes), error));
    return bytes;
  }
  tcp::acceptor acceptor;
  std::optional<tcp::socket> peer;
};

struct Client {
  explicit Client(boost::asio::io_context& context)
      : io(context),
        client(io, {[this](std::span<const std::uint8_t> bytes) {
                      received.insert(received.end(), bytes.begin(), bytes.end());
                    },
                    [this] { ++changes; }}) {}
  bool Until(const std::function<bool()>& so) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience;
         std::chrono::steady_clock::now() < end;) {
      if (so()) return true;
      io.run_for(std::chrono::milliseconds(2));
      io.restart();
    }
    return false;
  }
  boost::asio::io_context& io;
  TcpClient client;
  std::vector<std::uint8_t> received;
  int changes = 0;
};

TEST(TcpClient, IsToldOfEachEndOfAConnectionAndOpensItAgain) {
  boost::asio::io_context io;
  Server server(io);
  Client c(io);
  EXPECT_NE(c.client.Error(), "");
  c.client.Open({server.acceptor.local_endpoint()});
  ASSERT_TRUE(c.Until([&] { return server.Accept(); }));
  ASSERT_TRUE(c.Until([&] { return c.client.open(); }));
  EXPECT_EQ(c.client.Error(), "");
  EXPECT_EQ(c.changes, 1);
  const std::vector<std::uint8_t> bytes = {1, 2, 3};
  boost::asio::write(*server.peer, boost::asio::buffer(bytes));
  ASSERT_TRUE(c.Until([&] { return c.received == bytes; }));
  c.client.Send(bytes);
  ASSERT_TRUE(c.Until([&] { return server.Read() == bytes; }));
  server.peer.reset();  // it leaves
  ASSERT_TRUE(c.Until([&] { return !c.client.open(); }));
  EXPECT_THAT(c.client.Error(), HasSubstr("the other end has closed the connection; tried again"));
  EXPECT_EQ(c.changes, 2);
  c.client.Send(bytes);  // is lost, and nothing else
  ASSERT_TRUE(c.Until([&] { return server.Accept(); }));
  ASSERT_TRUE(c.Until([&] { return c.client.open(); }));
  c.client.Send({bytes.data(), 2});
  ASSERT_TRUE(c.Until([&] { return server.Read() == std::vector<std::uint8_t>({1, 2}); }));
}

TEST(TcpClient, AServerThatIsNotThereIsTriedUntilItIs) {
  boost::asio::io_context io;
  std::optional<Server> server(std::in_place, io);
  const tcp::endpoint at = server->acceptor.local_endpoint();
  server.reset();
  Client c(io);
  c.client.Open({at});
  ASSERT_TRUE(c.Until([&] { return c.changes == 1; }));
  EXPECT_THAT(c.client.Error(), HasSubstr("refused; tried again"));
  EXPECT_FALSE(c.client.open());
  server.emplace(io, at.port());
  EXPECT_TRUE(c.Until([&] { return c.client.open(); }));
}

TEST(TcpClient, WhoDoesNotReadMissesWholeMessagesAndIsSaidNotTo) {
  boost::asio::io_context io;
  Server server(io);
  Client c(io);
  c.client.Open({server.acceptor.local_endpoint()});
  ASSERT_TRUE(c.Until([&] { return server.Accept(); }));
  ASSERT_TRUE(c.Until([&] { return c.client.open(); }));
  constexpr std::size_t kSize = 200003;  // more than a queue holds: they go out in parts
  std::uint8_t number = 0;
  const auto send = [&] { c.client.Send(std::vector<std::uint8_t>(kSize, ++number)); };
  for (int i = 0; i < 5; ++i) send();
  EXPECT_THAT(c.client.Error(), HasSubstr("does not read"));
  ASSERT_TRUE(c.client.open());
  std::vector<std::uint8_t> got;
  ASSERT_TRUE(c.Until([&] {
    const auto more = server.Read();
    got.insert(got.end(), more.begin(), more.end());
    send();
    return got.size() > 4 * kSize;
  }));
  for (std::size_t whole = 0; whole < 4; ++whole) {
    const auto from = got.begin() + static_cast<std::ptrdiff_t>(whole * kSize);
    EXPECT_TRUE(std::all_of(from, from + kSize, [&](std::uint8_t each) { return each == *from; })) << whole;
  }
  EXPECT_GT(got[kSize], 2);  // others were left out meanwhile
  const std::vector<std::uint8_t> small = {1};
  EXPECT_TRUE(c.Until([&] {
    server.Read();
    c.client.Send(small);
    return c.client.Error().empty();
  }));
}

}  // namespace
}  // namespace kestrel::control
