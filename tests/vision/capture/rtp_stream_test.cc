// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/rtp_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kestrel::vision {
namespace {

using ::testing::HasSubstr;

TEST(RtpStream, IsReadAndWritten) {
  const auto plain = ParseRtpStream("rtp:5600");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->coding, RtpStream::Coding::kJpeg);
  EXPECT_EQ(plain->host, "127.0.0.1");
  EXPECT_EQ(plain->port, 5600);
  const auto far = ParseRtpStream("raw:192.168.1.7:65535");
  ASSERT_TRUE(far);
  EXPECT_EQ(far->coding, RtpStream::Coding::kRaw);
  EXPECT_EQ(far->host, "192.168.1.7");
  for (const char* text : {"rtp:5600", "raw:1", "raw:192.168.1.7:65535", "rtp:fe80::1:5600"})
    EXPECT_EQ(ToText(ParseRtpStream(text).value()), text);
}

TEST(RtpStream, NothingButAnAddressAndAPortGetsIntoAPipeline) {
  for (const char* text :
       {"", "rtp", "rtp:", "rtp:0", "rtp:65536", "rtp:-1", "rtp:5600x", "rtp: 5600", "5600", "udp:5600",
        "rtp:localhost:5600", "rtp::5600", "rtp:127.0.0.1 ! filesink location=x:5600", "rtp:5600 ! fakesink"})
    EXPECT_FALSE(ParseRtpStream(text)) << text;
}

TEST(RtpStream, TheReceiverListensWhereTheStreamGoes) {
  const std::string pipeline = ReceivingPipeline(ParseRtpStream("raw:5601").value(), {320, 240}, false);
  EXPECT_THAT(pipeline, HasSubstr("address=127.0.0.1 port=5601"));
  EXPECT_THAT(pipeline, HasSubstr("width=(string)320,height=(string)240"));
}

}  // namespace
}  // namespace kestrel::vision
