// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/udp_claim.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>

namespace kestrel::vision {
namespace {

using ::testing::HasSubstr;

// A program that listens, as a pipeline of GStreamer does: it lets others listen too.
class Listener {
 public:
  Listener() {
    const int yes = 1;
    setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&at), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size), 0);
    port = ntohs(at.sin_port);
  }
  ~Listener() { close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  std::uint16_t port = 0;

 private:
  int socket_ = socket(AF_INET, SOCK_DGRAM, 0);
};

TEST(UdpClaim, APortAtWhichAnotherListensIsRefusedUntilItIsFree) {
  std::optional<Listener> other(std::in_place);
  UdpClaim claim("127.0.0.1", other->port);
  EXPECT_THAT(claim.Take(), HasSubstr("is in use by another program"));
  EXPECT_THAT(claim.Take(), HasSubstr(std::to_string(other->port)));
  other.reset();
  EXPECT_EQ(claim.Take(), "");
}

TEST(UdpClaim, OfTwoThatAreAboutToListenOneMay) {
  std::uint16_t port = 0;
  {
    const Listener finds_one;
    port = finds_one.port;
  }
  std::optional<UdpClaim> first(std::in_place, "127.0.0.1", port);
  UdpClaim second("127.0.0.1", port);
  EXPECT_EQ(first->Take(), "");
  EXPECT_EQ(first->Take(), "");
  EXPECT_THAT(second.Take(), HasSubstr("is in use by another program"));
  first.reset();
  EXPECT_EQ(second.Take(), "");
}

TEST(UdpClaim, AnAddressThatIsNotThisComputersIsNamed) {
  EXPECT_THAT(UdpClaim("192.0.2.7", 5600).Take(), HasSubstr("UDP port 5600 of 192.0.2.7: "));
}

TEST(UdpClaim, ListenersOfMulticastDoNotExcludeEachOther) {
  UdpClaim first("239.1.2.3", 5601), second("239.1.2.3", 5601);
  EXPECT_EQ(first.Take(), "");
  EXPECT_EQ(second.Take(), "");
}

}  // namespace
}  // namespace kestrel::vision
