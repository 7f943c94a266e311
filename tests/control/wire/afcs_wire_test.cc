// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/yaml_fields.h"
#include "control/wire/afcs.h"
#include "tests/control/wire/other_afcs_profile.h"

namespace kestrel::control::wire {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
using Numbers = std::mt19937_64;

const AfcsCodec& Codec() {
  static const AfcsCodec codec{ThesisAfcsProfile()};
  return codec;
}
AfcsRefusal WhyNot(const AfcsCodec& codec, const Bytes& bytes) {
  return std::get<AfcsRefusal>(codec.Decode(bytes));  // throws where it was accepted
}
AfcsDatagram Decoded(const AfcsCodec& codec, const Bytes& bytes) {
  return std::get<AfcsDatagram>(codec.Decode(bytes));
}

// Messages of which every member is another number, and one that each integer and float type holds.
std::vector<AfcsMessage> Examples() {
  return {AfcsOpen{},
          AfcsAck{10},
          AfcsState{1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14,
                    15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27},
          AfcsGpsState{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14},
          AfcsFlyTo{1, 2, 3, 4, 5, 6, 7},
          AfcsTeleop{1, 2, 3, 4},
          AfcsDesiredPosition{1, 2, 3, 4},
          AfcsPlatform{1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
          AfcsClose{}};
}

// ---------------------------------------------------------------------------------- the thesis's layout

// The datagram by hand: header in network order, numbers of the payload as they are given.
class ByHand {
 public:
  explicit ByHand(std::uint32_t type) {
    for (const std::uint32_t number : {0x01020304U, 0x00050607U, type})
      for (int shift = 24; shift >= 0; shift -= 8)
        bytes_.push_back(static_cast<std::uint8_t>(number >> shift));
  }
  ByHand& Doubles(int first, int last) {
    for (int i = first; i <= last; ++i) Little(std::bit_cast<std::uint64_t>(static_cast<double>(i)), 8);
    return *this;
  }
  ByHand& Shorts(int first, int last) {
    for (int i = first; i <= last; ++i) Little(static_cast<std::uint64_t>(i), 2);
    return *this;
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  void Little(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  }
  Bytes bytes_;
};

TEST(AfcsLayoutOfTheThesis, EveryMessageIsTheStructOfAppendixB) {
  Bytes ack = ByHand(2).bytes();
  ack.insert(ack.end(), {0, 0, 0, 10});
  const std::vector<Bytes> expected = {
      ByHand(1).bytes(),
      ack,
      ByHand(10).Doubles(1, 23).Shorts(24, 27).bytes(),
      ByHand(12).Shorts(1, 4).Doubles(5, 14).bytes(),
      ByHand(16).Shorts(1, 3).Shorts(0, 0).Doubles(4, 7).bytes(),
      ByHand(21).Doubles(1, 4).bytes(),
      ByHand(20).Doubles(1, 4).bytes(),
      ByHand(19).Shorts(1, 1).Shorts(0, 0).Shorts(0, 0).Shorts(0, 0).Doubles(2, 10).bytes(),
      ByHand(3).bytes()};
  const std::vector<std::size_t> payloads = {0, 4, 192, 88, 40, 32, 32, 80, 0};
  const auto examples = Examples();
  ASSERT_EQ(examples.size(), expected.size());
  ASSERT_EQ(examples.size(), std::variant_size_v<AfcsMessage>);
  for (std::size_t i = 0; i < examples.size(); ++i) {
    const AfcsDatagram datagram{{0x01020304, 0x00050607}, examples[i]};
    EXPECT_EQ(Codec().Encode(datagram), expected[i]) << i;
    EXPECT_EQ(Decoded(Codec(), expected[i]), datagram) << i;
    EXPECT_EQ(expected[i].size(), 12 + payloads[i]) << i;
    EXPECT_EQ(Codec().datagram_bytes(examples[i].index()), expected[i].size()) << i;
  }
}

TEST(AfcsLayoutOfTheThesis, NegativeAndExtremeNumbersReturn) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<AfcsMessage> messages = {
      AfcsTeleop{-0.25, inf, -inf, std::numeric_limits<double>::denorm_min()},
      AfcsFlyTo{-32768, 32767, -1, -1e300, 1e-300, -0.0, 3},
      AfcsState{.voltage = -1, .resets = 65535, .rpm0 = 0, .rpm1 = 32768, .rpm2 = 1}};
  for (const AfcsMessage& message : messages) {
    const AfcsDatagram datagram{{0xFFFFFFFF, 999999}, message};
    EXPECT_EQ(Decoded(Codec(), Codec().Encode(datagram)), datagram);
  }
  const auto teleop = std::get<AfcsTeleop>(
      Decoded(Codec(), Codec().Encode({{1, 1}, AfcsTeleop{.fore = std::nan("")}})).message);
  EXPECT_TRUE(std::isnan(teleop.fore));
}

TEST(AfcsLayoutOfTheThesis, PaddingIsNotRead) {
  Bytes bytes = Codec().Encode({{1, 2}, AfcsFlyTo{1, 2, 3, 4, 5, 6, 7}});
  bytes[12 + 6] = 0xFF;
  EXPECT_EQ(Decoded(Codec(), bytes).message, AfcsMessage(AfcsFlyTo{1, 2, 3, 4, 5, 6, 7}));
}

// ---------------------------------------------------------------------------------- other profiles

TEST(AfcsProfiles, EveryTypeOrderAndWidthReturns) {
  const AfcsCodec codec(OtherAfcsProfile());
  EXPECT_EQ(codec.header_bytes(), 20U);
  for (const AfcsMessage& message : Examples()) {
    const AfcsDatagram datagram{{7, 8}, message};
    EXPECT_EQ(Decoded(codec, codec.Encode(datagram)), datagram);
  }
}

TEST(AfcsProfiles, AFileMayReplaceALayout) {
  AfcsProfile profile = ThesisAfcsProfile();
  FieldWriter writer;
  Fields(writer, profile);
  // The teleoperation, last of the thesis's, is a mark and two big-endian floats here.
  const std::string fields = "[{name: pad, type: u16}, {name: hdg, type: f32}, {name: fore, type: f32}]";
  Mistakes mistakes;
  const Config config =
      ParseConfig(writer.text(), "profile",
                  {"messages.8.id=30", "messages.8.byte_order=big", "messages.8.fields=" + fields}, mistakes);
  AfcsProfile read;
  FieldReader reader(config.root, "", mistakes);
  Fields(reader, read);
  reader.Finish();
  EXPECT_THAT(mistakes.Texts(), ElementsAre());
  EXPECT_THAT(MistakesOf(read), ElementsAre());
  const AfcsCodec codec(read);
  EXPECT_EQ(codec.Encode({{0, 1}, AfcsTeleop{.fore = 1, .side = 9, .alt = 9, .hdg = -2}}),
            (Bytes{0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 30, 0, 0, 0xC0, 0, 0, 0, 0x3F, 0x80, 0, 0}));
  const AfcsDatagram state{{3, 4}, Examples()[2]};
  EXPECT_EQ(codec.Encode(state), Codec().Encode(state));  // the others are as they were
}

TEST(AfcsProfiles, NumbersThatDoNotFitAreSentAsTheNearestAndRefusedWhenRead) {
  AfcsProfile profile = ThesisAfcsProfile();
  for (AfcsLayout& message : profile.messages) {
    if (message.name == "teleop")
      message.fields = {{"fore", "i16"}, {"side", "u32"}, {"alt", "f32"}, {"hdg", "u16"}};
    if (message.name == "gps_state") message.fields = {{"numsv", "f64"}};
  }
  const AfcsCodec codec(profile);
  const auto sent = [&](const AfcsTeleop& teleop) {
    return std::get<AfcsTeleop>(Decoded(codec, codec.Encode({{}, teleop})).message);
  };
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(sent({-1e9, -1, 1e300, std::nan("")}), (AfcsTeleop{-32768, 0, inf, 0}));
  EXPECT_EQ(sent({1e9, 1e12, -1e300, 1.6}), (AfcsTeleop{32767, 4294967295.0, -inf, 2}));
  Bytes gps = codec.Encode({{}, AfcsGpsState{.numsv = 7}});
  EXPECT_EQ(std::get<AfcsGpsState>(Decoded(codec, gps).message).numsv, 7);
  for (const double wrong : {32768.0, -32769.0, 1e300, inf, std::nan("")}) {
    gps.resize(12);
    Append(gps, wrong);
    EXPECT_EQ(WhyNot(codec, gps), AfcsRefusal::kRange) << wrong;
  }
}

TEST(AfcsProfiles, AllMistakesAreNamedAtOnce) {
  AfcsProfile profile = ThesisAfcsProfile();
  profile.header_byte_order = "network";
  profile.time_bytes = 6;
  profile.messages[0].name = "hello";  // so that open is missing
  profile.messages[2].id = 2;          // the ack's
  profile.messages[3].fields[1].name = "thetta";
  profile.messages[4].fields[0].type = "int";
  profile.messages[5].fields[0].name = "hdg_mode";
  profile.messages.push_back(profile.messages[8]);
  profile.messages.back().id = 257;
  profile.messages[6].byte_order = "middle";
  EXPECT_THAT(
      MistakesOf(profile),
      UnorderedElementsAre(
          "thesis: header_byte_order: neither little nor big", "thesis: time_bytes: neither 4 nor 8",
          "thesis: hello: no such message", "thesis: open: missing", "thesis: close: has the id of another",
          "thesis: state.thetta: no such field", "thesis: gps_state.numsv: no such type: int",
          "thesis: fly_to.hdg_mode: given twice", "thesis: teleop: given twice",
          "thesis: teleop: id not within 0..256", "thesis: platform: byte_order is neither little nor big"));
  try {
    const AfcsCodec codec(profile);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("hello"));
    EXPECT_THAT(error.what(), HasSubstr("open: missing"));
  }
}

// ---------------------------------------------------------------------------------- the receiver's rules

Bytes At(std::uint32_t seconds, std::uint32_t microseconds, const AfcsMessage& message) {
  return Codec().Encode({{seconds, microseconds}, message});
}

TEST(AfcsReceiver, LengthsMustBeExact) {
  for (const AfcsMessage& message : Examples()) {
    const Bytes good = At(1, 1, message);
    for (std::size_t length = 0; length <= good.size() + 200; ++length) {
      Bytes bytes = good;
      bytes.resize(length);
      AfcsReceiver receiver{Codec()};
      ASSERT_EQ(receiver.Receive(bytes).has_value(), length == good.size());
      ASSERT_EQ(receiver.refused(AfcsRefusal::kShort), length < 12 ? 1U : 0U);
      ASSERT_EQ(receiver.refused(AfcsRefusal::kLength), length >= 12 && length != good.size() ? 1U : 0U);
    }
  }
}

TEST(AfcsReceiver, TypesAboveTheLargestAreInvalidAndOthersUnknown) {
  Bytes bytes = At(1, 1, AfcsOpen{});
  const auto of_type = [&](std::uint32_t type) {
    for (std::size_t i = 0; i < 4; ++i) bytes[8 + i] = static_cast<std::uint8_t>(type >> (24 - 8 * i));
    return WhyNot(Codec(), bytes);
  };
  for (const std::uint32_t type : {257U, 65536U, 0x01000000U, 0xFFFFFFFFU})
    EXPECT_EQ(of_type(type), AfcsRefusal::kType);
  for (const std::uint32_t type : {0U, 11U, 22U, 255U, 256U}) EXPECT_EQ(of_type(type), AfcsRefusal::kUnknown);
}

TEST(AfcsReceiver, ASecondHasAMillionMicroseconds) {
  Bytes bytes = At(1, 999999, AfcsOpen{});
  EXPECT_EQ(Decoded(Codec(), bytes).time, (AfcsTime{1, 999999}));
  ++bytes[7];  // 999999 = 0x0F423F
  EXPECT_EQ(WhyNot(Codec(), bytes), AfcsRefusal::kTime);
  const AfcsCodec wide(OtherAfcsProfile());
  bytes = wide.Encode({{1, 2}, AfcsOpen{}});
  bytes[4] = 1;  // 2^32 seconds
  EXPECT_EQ(WhyNot(wide, bytes), AfcsRefusal::kTime);
}

TEST(AfcsReceiver, DuplicatesAndOldOnesAreDroppedByType) {
  AfcsReceiver receiver{Codec()};
  const AfcsMessage state = AfcsState{}, gps = AfcsGpsState{};
  EXPECT_TRUE(receiver.Receive(At(10, 5, state)));
  EXPECT_FALSE(receiver.Receive(At(10, 5, state)));    // duplicate
  EXPECT_FALSE(receiver.Receive(At(10, 5, gps)));      // the time of the last, of whatever type
  EXPECT_TRUE(receiver.Receive(At(9, 999999, gps)));   // older, but the first of its type
  EXPECT_FALSE(receiver.Receive(At(10, 5, state)));    // duplicate of the last of its type
  EXPECT_FALSE(receiver.Receive(At(10, 4, state)));    // old
  EXPECT_FALSE(receiver.Receive(At(9, 999998, gps)));  // old
  EXPECT_TRUE(receiver.Receive(At(10, 6, state)));
  EXPECT_TRUE(receiver.Receive(At(10, 0, gps)));
  EXPECT_EQ(receiver.accepted(), 4U);
  EXPECT_EQ(receiver.refused(AfcsRefusal::kDuplicate), 3U);
  EXPECT_EQ(receiver.refused(AfcsRefusal::kOld), 2U);
  receiver.Reset();
  EXPECT_TRUE(receiver.Receive(At(1, 0, state)));
}

TEST(AfcsReceiver, WhatWasRefusedSetsNoTime) {
  AfcsReceiver receiver{Codec()};
  Bytes longer = At(100, 0, AfcsState{});
  longer.push_back(0);
  EXPECT_FALSE(receiver.Receive(longer));
  EXPECT_TRUE(receiver.Receive(At(1, 0, AfcsState{})));
}

TEST(AfcsReceiver, TimesOfAfterAreNeverDropped) {
  AfcsReceiver receiver{Codec()};
  AfcsTime last;
  // A clock that stands still at the end of a second, runs, and goes back.
  for (const AfcsTime& now :
       std::vector<AfcsTime>{{5, 999998}, {5, 999998}, {5, 999998}, {6, 7}, {2, 0}, {6, 8}}) {
    last = After(last, now);
    EXPECT_TRUE(receiver.Receive(Codec().Encode({last, AfcsTeleop{}})));
  }
  EXPECT_EQ(last, (AfcsTime{6, 9}));
}

// ---------------------------------------------------------------------------------- damage

// Everything before the payload but the times is fixed, so of the header's flips only those of times, and of
// types to one with the same length, can pass.
TEST(AfcsDamage, OneWrongBitPassesOnlyWhereNothingGuardsIt) {
  for (const AfcsMessage& message : Examples()) {
    const Bytes good = At(1000, 500000, message);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      Bytes bytes = good;
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1 << bit % 8);
      const auto decoded = Codec().Decode(bytes);
      const auto* datagram = std::get_if<AfcsDatagram>(&decoded);
      if (bit < 32) {
        ASSERT_TRUE(datagram) << "any second may be";
      } else if (bit < 64) {
        const std::uint32_t microseconds = bytes[4] << 24U | bytes[5] << 16U | bytes[6] << 8U | bytes[7];
        ASSERT_EQ(datagram != nullptr, microseconds < 1000000);
      } else if (bit < 96) {
        const std::uint32_t type = bytes[8] << 24U | bytes[9] << 16U | bytes[10] << 8U | bytes[11];
        // By the table of B.1.1: 1 and 3 are empty, 20 and 21 have four doubles.
        const bool same_length = (good[11] == 1 && type == 3) || (good[11] == 3 && type == 1) ||
                                 (good[11] == 20 && type == 21) || (good[11] == 21 && type == 20);
        ASSERT_EQ(datagram != nullptr, same_length) << type;
      } else {
        ASSERT_TRUE(datagram);
        ASSERT_EQ(datagram->message.index(), message.index());
      }
    }
  }
}

Bytes Random(Numbers& numbers, std::size_t count) {
  Bytes bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(numbers());
  return bytes;
}

// Whatever comes, nothing breaks, every datagram is counted once, what is accepted is one of the profile in
// length and type, and a good one in between is accepted as it is.
TEST(AfcsDamage, AMillionDamagedDatagramsBreakNothing) {
  Numbers numbers(1);
  constexpr std::uint32_t kTrials = 1'000'000;
  const auto examples = Examples();
  std::vector<Bytes> frames;
  for (const AfcsMessage& message : examples) frames.push_back(At(1000, 500000, message));
  AfcsReceiver receiver{Codec()};
  std::uint64_t accepted = 0;
  for (std::uint32_t i = 0; i < kTrials; ++i) {
    Bytes bytes = frames[numbers() % frames.size()];
    switch (numbers() % 4) {
      case 0:
        bytes = Random(numbers, numbers() % 220);
        break;
      case 1:
        bytes.resize(numbers() % 220);
        break;
      case 2:
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(numbers() % bytes.size()));
        break;
      default:
        for (int k = 0; k < 4; ++k) bytes[numbers() % bytes.size()] = static_cast<std::uint8_t>(numbers());
    }
    if (const auto datagram = receiver.Receive(bytes)) {
      ++accepted;
      ASSERT_EQ(bytes.size(), Codec().datagram_bytes(datagram->message.index()));
      const Bytes again = Codec().Encode(*datagram);
      ASSERT_TRUE(std::equal(again.begin(), again.begin() + 12, bytes.begin()));
    }
    if (i % 100 == 99) {
      receiver.Reset();
      const AfcsDatagram good{{1, i % 1000000}, examples[i / 100 % examples.size()]};
      const auto datagram = receiver.Receive(Codec().Encode(good));
      ASSERT_TRUE(datagram && *datagram == good);
      ++accepted;
    }
  }
  std::uint64_t refused = 0;
  for (std::size_t why = 0; why < kAfcsRefusals; ++why)
    refused += receiver.refused(static_cast<AfcsRefusal>(why));
  EXPECT_EQ(receiver.accepted(), accepted);
  EXPECT_EQ(accepted + refused, kTrials + kTrials / 100);
  EXPECT_EQ(receiver.refused(AfcsRefusal::kRange), 0U);  // every type of this profile holds its own
  for (const auto why : {AfcsRefusal::kShort, AfcsRefusal::kTime, AfcsRefusal::kType, AfcsRefusal::kUnknown,
                         AfcsRefusal::kLength, AfcsRefusal::kDuplicate, AfcsRefusal::kOld})
    EXPECT_GT(receiver.refused(why), 0U) << static_cast<int>(why);
}

}  // namespace
}  // namespace kestrel::control::wire
