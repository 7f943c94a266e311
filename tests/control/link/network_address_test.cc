// SPDX-License-Identifier: Apache-2.0
#include "control/link/network_address.h"

#include <gtest/gtest.h>

#include "base/diagnostics.h"

namespace kestrel::control {
namespace {

TEST(UdpAddress, ToSendToOrToListenOn) {
  const UdpAddress to = ParseUdpAddress("udp://uav.local:14580");
  EXPECT_FALSE(to.listen);
  EXPECT_EQ(to.host, "uav.local");
  EXPECT_EQ(to.port, 14580);
  const UdpAddress in = ParseUdpAddress("udpin://0.0.0.0:14540");
  EXPECT_TRUE(in.listen);
  EXPECT_EQ(in.host, "0.0.0.0");
  EXPECT_EQ(ParseUdpAddress("udpin://:0").host, "127.0.0.1");
  EXPECT_EQ(ParseUdpAddress("udp://[::1]:5").host, "::1");
  for (const char* text : {"udp://[::1]:5", "udpin://127.0.0.1:0", "udp://a:65535"})
    EXPECT_EQ(ToText(ParseUdpAddress(text)), text);
}

TEST(UdpAddress, NothingElse) {
  for (const char* text :
       {"", "127.0.0.1:14540", "tcp://a:1", "udp://a", "udp://:5", "udp://a:", "udp://a:65536", "udp://a:-1",
        "udp://a:1x", "udp://a:0", "udp://::1:5", "udpin://14540"})
    EXPECT_THROW(ParseUdpAddress(text), InputError) << text;
}

TEST(TcpAddress, OfAServerAlone) {
  const TcpAddress to = ParseTcpAddress("tcp://127.0.0.1:5760");
  EXPECT_EQ(to.host, "127.0.0.1");
  EXPECT_EQ(to.port, 5760);
  for (const char* text : {"tcp://[::1]:5", "tcp://a:65535"}) EXPECT_EQ(ToText(ParseTcpAddress(text)), text);
  for (const char* text : {"", "127.0.0.1:5760", "udp://a:1", "tcp://a", "tcp://:5", "tcp://a:0",
                           "tcp://a:65536", "tcp://::1:5", "tcp://5760"})
    EXPECT_THROW(ParseTcpAddress(text), InputError) << text;
}

}  // namespace
}  // namespace kestrel::control
