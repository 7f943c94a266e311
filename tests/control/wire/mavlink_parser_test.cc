// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "tests/control/mavlink_frames.h"

namespace kestrel::control::wire::mavlink {
namespace {

constexpr Source kAutopilot{1, 1};

std::vector<Message> Decoded(const std::vector<Frame>& frames) {
  std::vector<Message> messages;
  for (const Frame& frame : frames) messages.push_back(Decode(frame).value());
  return messages;
}

// A message that no parser here knows, of this payload.
Bytes Unknown(std::uint8_t sequence, const Bytes& payload, std::uint8_t system = 1) {
  const auto length = static_cast<std::uint8_t>(payload.size());
  return WithChecksum(Bytes{0xFD, length, 0, 0, sequence, system, 1, 0x81, 0x01, 0} + payload, 147);
}

TEST(MavlinkParser, AStreamMayBeDividedAnyhow) {
  std::mt19937 random(2);
  Sender sender(1, 1);
  Bytes stream{1, 0xFD, 2, 0xFE, 0xFD};
  for (int i = 0; i < 300; ++i) {
    stream = stream + sender.Encode(Vectors()[static_cast<std::size_t>(i) % Vectors().size()].message);
    if (i % 7 == 0) stream = stream + Unknown(0, {1, 2, 3});
    for (int noise = i % 3 * 4; noise > 0; --noise) stream.push_back(static_cast<std::uint8_t>(random()));
  }
  stream = stream + sender.Encode(Heartbeat{});
  Parser whole(Formats());
  const std::vector<Message> expected = Decoded(whole.Stream(stream));
  EXPECT_EQ(expected.size(), 301U);
  for (const std::size_t longest : {1U, 2U, 50U, 1000U}) {
    Parser parser(Formats());
    std::vector<Message> messages;
    std::size_t at = 0;
    while (at < stream.size()) {
      const std::size_t count = std::min<std::size_t>(1 + random() % longest, stream.size() - at);
      for (const Message& m : Decoded(parser.Stream(std::span(stream).subspan(at, count))))
        messages.push_back(m);
      at += count;
    }
    EXPECT_TRUE(messages == expected) << longest;
    EXPECT_EQ(parser.counts().stray_bytes, whole.counts().stray_bytes);
    EXPECT_EQ(parser.counts().unknown, whole.counts().unknown);
    EXPECT_EQ(parser.counts().bad_flags, whole.counts().bad_flags);
    EXPECT_EQ(parser.counts().unconfirmed, whole.counts().unconfirmed);
  }
}

// In a datagram nothing comes of it; in a stream nothing comes of it either, and all after it does.
TEST(MavlinkParser, NoSingleBitErrorIsBelievedNorCostsAnotherFrame) {
  int checked = 0;
  for (const Vector& vector : Vectors()) {
    if (vector.header.is_signed) continue;
    const Bytes good = FromHex(vector.hex);
    const Bytes marker = Sender(vector.header.system, vector.header.component).Encode(Timesync{.tc1 = 77});
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      Bytes bad = good;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      Parser datagrams(Formats());
      datagrams.Datagram(marker);  // its sender is known
      ASSERT_TRUE(datagrams.Datagram(bad).empty()) << vector.hex << " bit " << bit;
      Parser stream(Formats());
      stream.Stream(marker);
      std::size_t found = stream.Stream(bad).size();
      constexpr std::size_t kMarkers = 40;
      for (std::size_t i = 0; i < kMarkers; ++i) found += stream.Stream(marker).size();
      // All but those that the length of a longest frame still hides.
      ASSERT_GE(found + 280 / marker.size() + 1, kMarkers) << vector.hex << " bit " << bit;
      found += stream.Stream(Bytes(300)).size();
      ASSERT_EQ(found, kMarkers) << vector.hex << " bit " << bit;
      ++checked;
    }
  }
  EXPECT_GT(checked, 30000);
}

TEST(MavlinkParser, EachRefusalHasItsReason) {
  const Bytes good = Sender(1, 1).Encode(Attitude{.time_boot_ms = 5, .yawspeed = 1});
  const auto after = [](const Bytes& bytes) {
    Parser parser(Formats());
    EXPECT_TRUE(parser.Datagram(bytes).empty());
    EXPECT_EQ(parser.counts().stray_bytes, bytes.size());
    return parser.counts();
  };
  EXPECT_EQ(after({1, 2, 3}).bad_checksum, 0U);
  Bytes bad = good;
  bad.back() ^= 1;
  EXPECT_EQ(after(bad).bad_checksum, 1U);
  bad = good, bad[2] = 2;
  EXPECT_EQ(after(bad).bad_flags, 1U);
  EXPECT_EQ(after(Bytes(good.begin(), good.end() - 1)).cut_short, 1U);
  EXPECT_EQ(after(Bytes(good.begin(), good.begin() + 3)).cut_short, 1U);
  EXPECT_EQ(after(Unknown(0, {1})).unconfirmed, 1U);
  EXPECT_EQ(after(WithChecksum({0xFE, 3, 0, 1, 1, 2, 1, 2, 3}, 137)).bad_length, 1U);
}

TEST(MavlinkParser, SeveralFramesAndNoiseInADatagram) {
  Sender sender(1, 1);
  const Bytes a = sender.Encode(Heartbeat{}), b = sender.Encode(Attitude{.roll = 1});
  Parser parser(Formats());
  EXPECT_EQ(parser.Datagram(Bytes{0xFD} + a + Bytes{0, 0xFE, 9} + b + Bytes{0xFD, 200, 0}).size(), 2U);
  EXPECT_EQ(parser.counts().stray_bytes, 7U);
  // The end of that datagram is not the beginning of this one.
  EXPECT_EQ(parser.Datagram(a).size(), 1U);
  EXPECT_EQ(parser.counts().stray_bytes, 7U);
}

// What another message carries is not for us, though it look like a frame; but only a sender who is known
// gets that much trust, and only when what follows confirms the length.
TEST(MavlinkParser, UnknownMessagesArePassedOverWhole) {
  const Bytes inside = Sender(1, 1).Encode(CommandLong{.command = 400});
  const Bytes heartbeat = Sender(1, 1).Encode(Heartbeat{});
  Parser parser(Formats());
  EXPECT_EQ(parser.Datagram(heartbeat).size(), 1U);
  EXPECT_EQ(parser.Datagram(Unknown(1, inside)).size(), 0U);
  EXPECT_EQ(parser.Datagram(Unknown(2, inside) + Unknown(3, inside)).size(), 0U);
  EXPECT_EQ(parser.counts().unknown, 3U);
  EXPECT_EQ(parser.counts().stray_bytes, 0U);
  EXPECT_EQ(parser.traffic().at(kAutopilot).lost, 0U);
  EXPECT_EQ(parser.traffic().at(kAutopilot).frames, 4U);
  // Bytes were lost: what seems its end is within the next frame, which must not be lost with them.
  Bytes torn = Unknown(4, {9, 9, 9, 9, 9, 9});
  torn.erase(torn.begin() + 12, torn.begin() + 15);
  EXPECT_EQ(parser.Datagram(torn + heartbeat).size(), 1U);
  EXPECT_EQ(parser.counts().unconfirmed, 1U);
  // Cut in its header: what seems its length ends with the frame after it.
  const Bytes header = Unknown(6, Bytes(heartbeat.size() - 5));
  EXPECT_EQ(parser.Datagram(Bytes(header.begin(), header.begin() + 7) + heartbeat + heartbeat).size(), 2U);
  // From system 2 nothing has come.
  EXPECT_EQ(parser.Datagram(Unknown(5, heartbeat, 2)).size(), 1U);
}

TEST(MavlinkParser, CountsWhatIsLostOfEachSource) {
  const auto frame = [](std::uint8_t system, int sequence) {
    return WithChecksum({0xFD, 1, 0, 0, static_cast<std::uint8_t>(sequence), system, 1, 0, 0, 0, 1}, 50);
  };
  Parser parser(Formats());
  for (const int sequence : {250, 251, 254, 0, 1}) parser.Datagram(frame(1, sequence));
  for (const int sequence : {7, 7, 8}) parser.Datagram(frame(2, sequence));
  EXPECT_EQ(parser.traffic().at({1, 1}).frames, 5U);
  EXPECT_EQ(parser.traffic().at({1, 1}).lost, 3U);  // 252, 253 and 255
  EXPECT_EQ(parser.traffic().at({1, 1}).repeated, 0U);
  EXPECT_EQ(parser.traffic().at({2, 1}).lost, 0U);
  EXPECT_EQ(parser.traffic().at({2, 1}).repeated, 1U);
  parser.Datagram(frame(1, 255));  // late
  EXPECT_EQ(parser.traffic().at({1, 1}).lost, 2U);
  parser.Datagram(frame(1, 2));
  EXPECT_EQ(parser.traffic().at({1, 1}).lost, 2U);
  EXPECT_EQ(parser.traffic().size(), 2U);
}

// A million frames, every second one damaged. Those that are whole come out, and of the damaged ones no more
// than chance has it: a sum of 16 bits that holds, or a byte that was cut off and that is there again as the
// first one of what follows.
TEST(MavlinkParser, AMillionFramesHalfOfThemDamaged) {
  std::mt19937 random(3);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  std::vector<Bytes> pool;
  Sender sender(1, 1);
  for (const Vector& vector : Vectors()) pool.push_back(sender.Encode(vector.message));
  Parser parser(Formats());
  std::uint64_t whole = 0, found = 0, damaged = 0, bytes = 0;
  parser.Stream(pool[0]);
  for (int chunk = 0; chunk < 10000; ++chunk) {
    Bytes stream;
    for (int i = 0; i < 100; ++i) {
      const Bytes& good = pool[below(pool.size())];
      Bytes frame = good;
      if (random() % 2 == 0) {
        const std::size_t at = below(frame.size());
        const auto place = frame.begin() + static_cast<std::ptrdiff_t>(at);
        switch (random() % 5) {
          case 0:
            frame[at] ^= static_cast<std::uint8_t>(1 << random() % 8);
            break;
          case 1:
            frame[at] ^= static_cast<std::uint8_t>(1 + random() % 255);
            break;
          case 2:
            frame.erase(place);
            break;
          case 3:
            frame.erase(place, frame.end());
            break;
          default: {
            Bytes noise(1 + below(40));
            for (std::uint8_t& byte : noise)
              byte = random() % 4 == 0 ? 0xFD : static_cast<std::uint8_t>(random());
            frame.insert(place, noise.begin(), noise.end());
          }
        }
      }
      // Noise before it does not damage a frame.
      ++(std::ranges::search(frame, good).empty() ? damaged : whole);
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    bytes += stream.size();
    for (const Frame& frame : parser.Stream(stream)) found += Decode(frame).has_value();
  }
  found += parser.Stream(Bytes(300)).size();
  std::cout << "  " << bytes << " bytes, " << whole << " whole frames, " << found << " found, " << damaged
            << " damaged\n";
  EXPECT_NEAR(static_cast<double>(found), static_cast<double>(whole), 100);
  EXPECT_EQ(whole + damaged, 1000000U);
}

TEST(MavlinkParser, NoiseAloneIsNothing) {
  std::mt19937 random(4);
  Parser parser(Formats());
  parser.Stream(Sender(1, 1).Encode(Heartbeat{}));
  std::uint64_t bytes = 0;
  for (int chunk = 0; chunk < 1000; ++chunk) {
    Bytes noise(1000);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    EXPECT_TRUE(parser.Stream(noise).empty());
    bytes += noise.size();
  }
  EXPECT_GE(parser.counts().stray_bytes + 280, bytes);
}

}  // namespace
}  // namespace kestrel::control::wire::mavlink
