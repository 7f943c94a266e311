// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/rtp_filter.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <vector>

namespace kestrel::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A socket of UDP and one that speaks to it.
class RtpFilterTest : public testing::Test {
 protected:
  RtpFilterTest() {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(bind(here_, reinterpret_cast<sockaddr*>(&at), size), 0);
    EXPECT_EQ(getsockname(here_, reinterpret_cast<sockaddr*>(&at), &size), 0);
    EXPECT_EQ(connect(there_, reinterpret_cast<sockaddr*>(&at), size), 0);
  }
  ~RtpFilterTest() override { close(here_), close(there_); }
  bool Comes(const Bytes& bytes) {
    EXPECT_EQ(send(there_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    Bytes got(65536);
    const ssize_t size = recv(here_, got.data(), got.size(), MSG_DONTWAIT);
    if (size < 0) return false;
    got.resize(static_cast<std::size_t>(size));
    EXPECT_EQ(got, bytes);
    return true;
  }
  const int here_ = socket(AF_INET, SOCK_DGRAM, 0), there_ = socket(AF_INET, SOCK_DGRAM, 0);
};

Bytes Rtp(int type, std::size_t size = 100) {
  Bytes bytes(size, 7);
  bytes[0] = 0x80, bytes[1] = static_cast<std::uint8_t>(type);
  return bytes;
}

TEST_F(RtpFilterTest, OnlyRtpOfTheTypesComes) {
  constexpr int kMarker = 0x80;
  ASSERT_EQ(TakeRtpOnly(here_, {26, 26}), "");
  EXPECT_TRUE(Comes(Rtp(26)));
  EXPECT_TRUE(Comes(Rtp(26 | kMarker)));
  EXPECT_TRUE(Comes(Rtp(26, 60000)));
  for (const int type : {0, 25, 27, 96, 127, 25 | kMarker, 27 | kMarker})
    EXPECT_FALSE(Comes(Rtp(type))) << type;
  for (const std::uint8_t first : {0x00, 0x40, 0xC0, 0x3F, 0x78}) {
    Bytes other = Rtp(26);
    other[0] = first;
    EXPECT_FALSE(Comes(other)) << int{first};
  }
  for (const std::size_t size : {0, 1, 2, 12, 19}) EXPECT_FALSE(Comes(Bytes(size, 0x80))) << size;
  EXPECT_TRUE(Comes(Rtp(26, 20)));  // both headers, and no image in them
}

TEST_F(RtpFilterTest, TypesAreARange) {
  ASSERT_EQ(TakeRtpOnly(here_, {96, 127}), "");
  for (const int type : {96, 110, 127}) EXPECT_TRUE(Comes(Rtp(type))) << type;
  for (const int type : {0, 26, 95}) EXPECT_FALSE(Comes(Rtp(type))) << type;
}

TEST_F(RtpFilterTest, WhatIsNoSocketIsTrouble) {
  EXPECT_NE(TakeRtpOnly(-1, {26, 26}).find("takes no filter"), std::string::npos);
}

}  // namespace
}  // namespace kestrel::vision
