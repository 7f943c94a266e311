// SPDX-License-Identifier: Apache-2.0
#include "sim/server/udp_relay.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <set>
#include <vector>

#include "base/stopwatch.h"

namespace kestrel::sim {
namespace {

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

class Socket {
 public:
  Socket() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const sockaddr_in any = Loopback(0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  }
  ~Socket() { close(socket_); }
  int port() const {
    sockaddr_in at{};
    socklen_t size = sizeof at;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size);
    return ntohs(at.sin_port);
  }
  void Send(int number, int to_port) {
    const sockaddr_in to = Loopback(to_port);
    sendto(socket_, &number, sizeof number, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  // What comes until as many are there, or the time is over.
  std::vector<int> Take(std::size_t count, double max_s = 10) {
    std::vector<int> numbers;
    const double until_s = MonotonicNow_s() + max_s;
    while (numbers.size() < count && MonotonicNow_s() < until_s) {
      pollfd waits{socket_, POLLIN, 0};
      if (poll(&waits, 1, 10) <= 0) continue;
      int number = 0;
      socklen_t size = sizeof from_;
      recvfrom(socket_, &number, sizeof number, 0, reinterpret_cast<sockaddr*>(&from_), &size);
      numbers.push_back(number);
    }
    return numbers;
  }
  int from_port() const { return ntohs(from_.sin_port); }

 private:
  int socket_;
  sockaddr_in from_{};
};

struct UdpRelayTest : ::testing::Test {
  Socket client, server;
  UdpRelay relay{"127.0.0.1", server.port(), 7};
  void Say(int count) {
    for (int i = 0; i < count; ++i) client.Send(i, relay.port());
  }
};

TEST_F(UdpRelayTest, HandsOnInBothDirectionsAndInOrder) {
  Say(20);
  const std::vector<int> up = server.Take(20);
  ASSERT_EQ(up.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(up[static_cast<std::size_t>(i)], i);
  server.Send(99, server.from_port());
  EXPECT_EQ(client.Take(1), std::vector{99});
  EXPECT_EQ(client.from_port(), relay.port());  // a client that heeds one address alone hears it
}

TEST_F(UdpRelayTest, LosesItsShare) {
  relay.Set({.lost = 0.3});
  for (int round = 0; round < 10; ++round) {  // no socket's buffer overflows
    Say(100);
    while (relay.counts().passed + relay.counts().lost < 100 * (round + 1)) usleep(1000);
  }
  EXPECT_NEAR(static_cast<double>(relay.counts().lost), 300, 60);  // four deviations
  EXPECT_EQ(relay.counts().lost + relay.counts().passed, 1000);
}

TEST_F(UdpRelayTest, DoublesEachOne) {
  relay.Set({.doubled = 1});
  Say(10);
  EXPECT_EQ(server.Take(20).size(), 20U);
}

TEST_F(UdpRelayTest, DelaysAndKeepsTheOrder) {
  relay.Set({.delay_s = 0.2});
  const double sent_s = MonotonicNow_s();
  Say(5);
  EXPECT_EQ(server.Take(5), (std::vector{0, 1, 2, 3, 4}));
  EXPECT_GE(MonotonicNow_s() - sent_s, 0.2);
}

TEST_F(UdpRelayTest, ScatteredTheyOvertakeEachOtherAndAllArrive) {
  relay.Set({.scatter_s = 0.05});
  Say(50);
  const std::vector<int> came = server.Take(50);
  EXPECT_EQ(std::set<int>(came.begin(), came.end()).size(), 50U);
  EXPECT_FALSE(std::is_sorted(came.begin(), came.end()));
  EXPECT_GT(relay.counts().overtaken, 10);
}

TEST_F(UdpRelayTest, WhatIsUnderWayWhenTheLineIsCutIsLost) {
  relay.Set({.delay_s = 0.1});
  Say(5);
  while (relay.counts().lost == 0) {  // once they are on the line
    relay.Set({.cut = true});
    usleep(1000);
  }
  Say(5);
  EXPECT_TRUE(server.Take(1, 0.2).empty());
  EXPECT_EQ(relay.counts().passed, 0);
  relay.Set({});
  client.Send(42, relay.port());
  EXPECT_EQ(server.Take(1), std::vector{42});
}

}  // namespace
}  // namespace kestrel::sim
