// SPDX-License-Identifier: Apache-2.0
#include "flight/live/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kestrel::flight {
namespace {

using testing::HasSubstr;

const Access kLoopback("127.0.0.1", "", {});
const Access kOpen("0.0.0.0", "0123abcd", {"https://app.foxglove.dev"});

TEST(LiveAccess, OnLoopbackWhoeverIsOnThisComputerMayWatch) {
  for (const char* host : {"127.0.0.1:8765", "localhost:8765", "[::1]:8765", "localhost:9000", "127.0.0.1"})
    EXPECT_EQ(kLoopback.Refusal({host, "", "/"}), "") << host;
  EXPECT_EQ(kLoopback.Refusal({"localhost:8765", "http://localhost:8765", "/live"}), "");
}

// A page of evil.example whose name was bound anew to 127.0.0.1 is of one origin with this server, for its browser.
TEST(LiveAccess, ANameThatIsBoundAnewIsRefused) {
  EXPECT_THAT(kLoopback.Refusal({"evil.example:8765", "http://evil.example:8765", "/live"}),
              HasSubstr("host"));
  EXPECT_THAT(kLoopback.Refusal({"192.168.1.4:8765", "", "/"}), HasSubstr("host"));
  EXPECT_THAT(kLoopback.Refusal({"", "", "/"}), HasSubstr("host"));
  EXPECT_THAT(kOpen.Refusal({"evil.example:8765", "", "/?token=0123abcd"}), HasSubstr("host"));
}

TEST(LiveAccess, APageOfAnotherSiteIsRefused) {
  for (const char* origin :
       {"http://evil.example", "null", "file://", "https://localhost:8765", "http://localhost:80"})
    EXPECT_THAT(kLoopback.Refusal({"localhost:8765", origin, "/live"}), HasSubstr("another site")) << origin;
  EXPECT_EQ(kOpen.Refusal({"10.0.0.2:8765", "https://app.foxglove.dev", "/?token=0123abcd"}), "");
  EXPECT_THAT(kOpen.Refusal({"10.0.0.2:8765", "https://app.foxglove.dev.evil.example", "/?token=0123abcd"}),
              HasSubstr("another site"));
}

// Its page is a file of this computer; a site in a frame without an origin is "null".
TEST(LiveAccess, FoxglovesApplicationMayWatch) {
  EXPECT_EQ(kLoopback.Refusal({"localhost:8765", "file://", "/", true}), "");
  EXPECT_EQ(kOpen.Refusal({"10.0.0.2:8765", "file://", "/?token=0123abcd", true}), "");
  EXPECT_THAT(kOpen.Refusal({"10.0.0.2:8765", "file://", "/", true}), HasSubstr("token"));
  for (const char* origin : {"null", "http://evil.example", "https://app.foxglove.dev"})
    EXPECT_THAT(kLoopback.Refusal({"localhost:8765", origin, "/", true}), HasSubstr("another site"))
        << origin;
}

TEST(LiveAccess, ElsewhereOnlyWhoKnowsTheTokenMay) {
  EXPECT_EQ(kOpen.Refusal({"10.0.0.2:8765", "", "/?token=0123abcd"}), "");
  EXPECT_EQ(kOpen.Refusal({"10.0.0.2:8765", "http://10.0.0.2:8765", "/live?a=b&token=0123abcd"}), "");
  for (const char* target : {"/", "/?", "/?token=", "/?token=0123abce", "/?token=0123abc",
                             "/?token=0123abcdd", "/?xtoken=0123abcd", "/?&&&", "/token=0123abcd"})
    EXPECT_THAT(kOpen.Refusal({"10.0.0.2:8765", "", target}), HasSubstr("token")) << target;
}

TEST(LiveAccess, NoTwoTokensAreAlike) {
  EXPECT_EQ(RandomToken().size(), 32u);
  EXPECT_NE(RandomToken(), RandomToken());
}

TEST(LiveAccess, WhatIsOnlyThisComputer) {
  for (const char* address : {"127.0.0.1", "127.1.2.3", "::1"}) EXPECT_TRUE(IsLoopback(address)) << address;
  for (const char* address : {"0.0.0.0", "10.0.0.1", "::", "localhost", ""})
    EXPECT_FALSE(IsLoopback(address)) << address;
}

}  // namespace
}  // namespace kestrel::flight
