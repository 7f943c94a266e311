// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/control/mavlink_frames.h"

namespace kestrel::control::wire::mavlink {

const std::vector<Vector>& Vectors() {
  static const std::vector<Vector> vectors{
#include "tests/control/wire/mavlink_vectors.inc"
  };
  return vectors;
}

Bytes FromHex(std::string_view hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

namespace {

TEST(MavlinkVectors, OfEveryMessage) {
  std::set<std::size_t> seen;
  for (const Vector& vector : Vectors()) seen.insert(vector.message.index());
  EXPECT_EQ(seen.size(), std::variant_size_v<Message>);
  EXPECT_EQ(Vectors().size(), 263U);
}

TEST(MavlinkVectors, AreReadToTheirValues) {
  for (const Vector& vector : Vectors()) {
    Parser parser(Formats());
    const std::vector<Frame> frames = parser.Datagram(FromHex(vector.hex));
    ASSERT_EQ(frames.size(), 1U) << vector.hex;
    EXPECT_EQ(frames[0].version, vector.header.version);
    EXPECT_EQ(frames[0].is_signed, vector.header.is_signed);
    EXPECT_EQ(frames[0].sequence, vector.header.sequence);
    EXPECT_EQ(frames[0].system, vector.header.system);
    EXPECT_EQ(frames[0].component, vector.header.component);
    const std::optional<Message> message = Decode(frames[0]);
    ASSERT_TRUE(message);
    EXPECT_TRUE(*message == vector.message) << vector.hex;
    EXPECT_EQ(parser.counts().frames, 1U);
    EXPECT_EQ(parser.counts().stray_bytes, 0U);
    EXPECT_EQ(parser.counts().signed_frames, vector.header.is_signed ? 1U : 0U);
    EXPECT_EQ(parser.counts().version1, vector.header.version == 1 ? 1U : 0U);
  }
}

TEST(MavlinkVectors, AreWrittenFromTheirValues) {
  int written = 0;
  for (const Vector& vector : Vectors()) {
    if (vector.header.version == 1 || vector.header.is_signed) continue;
    Sender sender(vector.header.system, vector.header.component);
    for (int skip = 0; skip < vector.header.sequence; ++skip) sender.Encode(Heartbeat{});
    EXPECT_EQ(sender.Encode(vector.message), FromHex(vector.hex));
    ++written;
  }
  EXPECT_EQ(written, 4 * 48);
}

}  // namespace
}  // namespace kestrel::control::wire::mavlink
