// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <random>
#include <string_view>
#include <type_traits>

#include "control/wire/asctec.h"
#include "control/wire/asctec_units.h"
#include "control/wire/crc16.h"

namespace kestrel::control::wire {
namespace {

using ::testing::ElementsAre;
using Numbers = std::mt19937_64;

Bytes Text(std::string_view text) { return {text.begin(), text.end()}; }

Bytes Joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// A frame by the table of the manual, with no help of the encoder.
Bytes FrameOf(std::uint8_t descriptor, const Bytes& data) {
  Crc16 crc(0x00FF);
  crc.Add(data);
  const auto length = static_cast<std::uint8_t>(data.size());
  return Joined({Text(">*>"),
                 {length, 0, descriptor},
                 data,
                 {static_cast<std::uint8_t>(crc.sum()), static_cast<std::uint8_t>(crc.sum() >> 8)},
                 Text("<#<")});
}

Bytes Random(Numbers& numbers, std::size_t count) {
  Bytes bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(numbers());
  return bytes;
}

template <class Parser>
auto FeedAll(Parser& parser, const Bytes& bytes) {
  auto messages = parser.Feed(bytes);
  for (auto& message : parser.Idle()) messages.push_back(message);
  return messages;
}
std::vector<Telemetry> Said(const Bytes& bytes) {
  TelemetryParser parser;
  return FeedAll(parser, bytes);
}
std::vector<Command> Asked(const Bytes& bytes) {
  CommandParser parser;
  return FeedAll(parser, bytes);
}

struct KindOfFrame {
  std::uint8_t descriptor;
  std::size_t bytes;
};
constexpr KindOfFrame kFrames[] = {{0x02, 16}, {0x01, 28}, {0x03, 92}, {0x15, 34},
                                   {0x11, 16}, {0x23, 44}, {0x29, 60}};

Bytes RandomFrame(Numbers& numbers) {
  const KindOfFrame& kind = kFrames[numbers() % std::size(kFrames)];
  return FrameOf(kind.descriptor, Random(numbers, kind.bytes));
}
CtrlInput RandomInput(Numbers& numbers) {
  const auto within = [&](int low, int high) {
    return static_cast<std::int16_t>(std::uniform_int_distribution<int>(low, high)(numbers));
  };
  return {within(-2047, 2047), within(-2047, 2047), within(-2047, 2047), within(0, 4095), within(0, 63)};
}

// ---------------------------------------------------------------------------------- layouts and vectors

// A number of a pattern alone in the struct is at its offset, in little-endian, and everything else is 0.
template <class S, class T>
void ExpectAt(T S::*member, std::size_t offset) {
  S message;
  const auto pattern = static_cast<T>(0x81726354A5968778);
  message.*member = pattern;
  Bytes data(S::kBytes, 0);
  for (std::size_t i = 0; i < sizeof(T); ++i)
    data.at(offset + i) = static_cast<std::uint8_t>(static_cast<std::make_unsigned_t<T>>(pattern) >> (8 * i));
  const Bytes frame = FrameOf(S::kDescriptor, data);
  EXPECT_EQ(Encode(message), frame) << "offset " << offset;
  EXPECT_THAT(Said(frame), ElementsAre(Telemetry(message))) << "offset " << offset;
}
template <class S, class... Members>
void ExpectFrom(std::size_t offset, Members S::*... members) {
  ((ExpectAt(members, offset), offset += sizeof(Members)), ...);
}

TEST(AscTecLayout, EveryFieldOfLlStatus) {
  using S = LlStatus;
  ExpectFrom(0, &S::battery_voltage_1, &S::battery_voltage_2, &S::status, &S::cpu_load);
  ExpectFrom(8, &S::compass_enabled, &S::chksum_error, &S::flying, &S::motors_on);
  ExpectFrom(12, &S::flightMode, &S::up_time);
}
TEST(AscTecLayout, EveryFieldOfImuRawData) {
  using S = ImuRawData;
  ExpectFrom(0, &S::pressure);
  ExpectFrom(4, &S::gyro_x, &S::gyro_y, &S::gyro_z);
  ExpectFrom(10, &S::mag_x, &S::mag_y, &S::mag_z);
  ExpectFrom(16, &S::acc_x, &S::acc_y, &S::acc_z);
  ExpectFrom(22, &S::temp_gyro);
  ExpectFrom(24, &S::temp_ADC);
}
TEST(AscTecLayout, EveryFieldOfImuCalcData) {
  using S = ImuCalcData;
  ExpectFrom(0, &S::angle_nick, &S::angle_roll, &S::angle_yaw);
  ExpectFrom(12, &S::angvel_nick, &S::angvel_roll, &S::angvel_yaw);
  ExpectFrom(24, &S::acc_x_calib, &S::acc_y_calib, &S::acc_z_calib);
  ExpectFrom(30, &S::acc_x, &S::acc_y, &S::acc_z);
  ExpectFrom(36, &S::acc_angle_nick, &S::acc_angle_roll);
  ExpectFrom(44, &S::acc_absolute_value);
  ExpectFrom(48, &S::Hx, &S::Hy, &S::Hz);
  ExpectFrom(60, &S::mag_heading);
  ExpectFrom(64, &S::speed_x, &S::speed_y, &S::speed_z);
  ExpectFrom(76, &S::height);
  ExpectFrom(80, &S::dheight);
  ExpectFrom(84, &S::dheight_reference);
  ExpectFrom(88, &S::height_reference);
}
TEST(AscTecLayout, EveryFieldOfCtrlOut) {
  ExpectFrom(0, &CtrlOut::nick, &CtrlOut::roll, &CtrlOut::yaw, &CtrlOut::thrust);
}
TEST(AscTecLayout, EveryFieldOfGpsData) {
  using S = GpsData;
  ExpectFrom(0, &S::latitude, &S::longitude);
  ExpectFrom(8, &S::height);
  ExpectFrom(12, &S::speed_x, &S::speed_y);
  ExpectFrom(20, &S::heading);
  ExpectFrom(24, &S::horizontal_accuracy, &S::vertical_accuracy, &S::speed_accuracy);
  ExpectFrom(36, &S::numSV);
  ExpectFrom(40, &S::status);
}
TEST(AscTecLayout, GpsDataAdvancedIsGpsDataAndTheBestEstimates) {
  using S = GpsDataAdvanced;
  ExpectFrom(44, &S::latitude_best_estimate, &S::longitude_best_estimate);
  ExpectFrom(52, &S::speed_x_best_estimate, &S::speed_y_best_estimate);
  GpsDataAdvanced message;
  message.gps.status = 3;
  Bytes data(60, 0);
  data[40] = 3;
  EXPECT_EQ(Encode(message), FrameOf(0x29, data));
}
TEST(AscTecLayout, EveryFieldOfRcDataWithAndWithoutPadding) {
  RcData message;
  Bytes data;
  for (std::uint16_t i = 0; i < 16; ++i) {
    auto& channels = i < 8 ? message.channels_in : message.channels_out;
    channels[i % 8] = static_cast<std::uint16_t>(0x0F01 + i);
    Append(data, static_cast<std::uint16_t>(0x0F01 + i));
  }
  Append(data, message.lock = 0xA7);
  const Bytes unpadded = FrameOf(0x15, data);
  data.push_back(0);
  EXPECT_EQ(Encode(message), FrameOf(0x15, data));
  EXPECT_EQ(unpadded.size() + 1, FrameOf(0x15, data).size());
  EXPECT_THAT(Said(Joined({unpadded, FrameOf(0x15, data), unpadded})),
              ElementsAre(message, message, message));
}

TEST(AscTecVectors, TheControlCommandOfTheReference) {
  const CtrlInput input{.pitch = 100, .roll = -50, .yaw = 0, .thrust = 2048, .ctrl = 0x0F};
  const Bytes bytes{0x3E, 0x2A, 0x3E, 0x64, 0x69, 0x64, 0x00, 0xCE, 0xFF,
                    0x00, 0x00, 0x00, 0x08, 0x0F, 0x00, 0xEB, 0xB2};
  EXPECT_EQ(Encode(input), bytes);
  EXPECT_THAT(Asked(bytes), ElementsAre(input));
}

TEST(AscTecVectors, RequestStopAndAcknowledgement) {
  const Request request{0x0204};  // a bit of each byte
  EXPECT_EQ(Encode(request), Joined({Text(">*>p"), {0x04, 0x02}}));
  EXPECT_EQ(Encode(EmergencyStop{}), Text(">*>me"));
  EXPECT_EQ(Encode(Acknowledgement{0x17}), Joined({Text(">a"), {0x17}, Text("a<")}));
  EXPECT_THAT(Asked(Joined({Encode(EmergencyStop{}), Encode(request)})),
              ElementsAre(EmergencyStop{}, request));
  EXPECT_THAT(Said(Encode(Acknowledgement{0x17})), ElementsAre(Acknowledgement{0x17}));
}

TEST(AscTecVectors, TheCheckSumOfAFrameIsThatOfItsDataAlone) {
  // "123456789" has 0x9DB8 by the published CRC; LL_STATUS of it and seven more is the CRC carried on.
  Bytes frame = FrameOf(0x02, Text("123456789abcdefg"));
  std::uint16_t crc = 0x00FF;  // bit by bit, reflected 0x1021
  for (const char c : std::string_view("123456789abcdefg")) {
    crc = static_cast<std::uint16_t>(crc ^ static_cast<std::uint8_t>(c));
    for (int i = 0; i < 8; ++i) crc = static_cast<std::uint16_t>(crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1);
  }
  EXPECT_EQ(frame[22] | frame[23] << 8, crc);
  ASSERT_EQ(Said(frame).size(), 1U);
  EXPECT_EQ(std::get<LlStatus>(Said(frame)[0]).battery_voltage_1, '1' | '2' << 8);
}

TEST(AscTecTiming, FramesTakeWhatTheTableSays) {
  const auto ms = [](const Telemetry& message) { return 1e3 * LineTime_s(Encode(message).size()); };
  EXPECT_NEAR(ms(LlStatus{}), 4.7, 0.05);
  EXPECT_NEAR(ms(CtrlOut{}), 4.7, 0.05);
  EXPECT_NEAR(ms(ImuCalcData{}), 17.9, 0.05);
  EXPECT_NEAR(ms(GpsData{}), 9.5, 0.06);
  EXPECT_NEAR(ms(GpsDataAdvanced{}), 12.3, 0.05);
  EXPECT_NEAR(ms(ImuRawData{}), 6.8, 0.05);
  EXPECT_NEAR(ms(ImuCalcData{}) + ms(GpsDataAdvanced{}) + ms(LlStatus{}), 34.9, 0.05);
  EXPECT_EQ(Encode(CtrlInput{}).size(), kCtrlInputBytes);
  EXPECT_EQ(Encode(Request{}).size(), kRequestBytes);
  EXPECT_EQ(Encode(Acknowledgement{}).size(), kAcknowledgementBytes);
}

TEST(AscTecUnits, FullDeflectionsAreTheDocumentedOnes) {
  constexpr double kDeg = std::numbers::pi / 180;
  EXPECT_EQ(StickCounts(51.175 * kDeg, kFullTilt_rad), 2047);
  EXPECT_EQ(StickCounts(-10 * kDeg, kFullTilt_rad), -400);  // 1000 / 25 counts to a degree
  EXPECT_NEAR(kFullYawRate_rad_s / kDeg, 245.64, 0.005);
  EXPECT_EQ(StickCounts(1.5, kFullGpsSpeed_m_s), 1024);
  EXPECT_EQ(ThrustCounts(0.5), 2048);
  EXPECT_EQ(ClimbCounts(0, 1), 2047);
  EXPECT_EQ(ClimbCounts(-1, 1), 0);
  EXPECT_NEAR(64.8 * kRad_sPerRateCount, kDeg, 1e-15);
  EXPECT_NEAR(360000 * kRadPerAngleCount, 2 * std::numbers::pi, 1e-12);
}
TEST(AscTecUnits, WhatIsTooMuchStaysWithinTheDeflection) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (const double full : {kFullTilt_rad, kFullYawRate_rad_s, kFullGpsSpeed_m_s}) {
    EXPECT_EQ(StickCounts(inf, full), 2047);
    EXPECT_EQ(StickCounts(-1e300, full), -2047);
    EXPECT_EQ(StickCounts(nan, full), 0);
  }
  EXPECT_EQ(ThrustCounts(-0.1), 0);
  EXPECT_EQ(ThrustCounts(1e9), 4095);
  EXPECT_EQ(ThrustCounts(nan), 0);
}
TEST(AscTecUnits, EveryCountReturns) {
  for (std::int16_t counts = -2047; counts <= 2047; ++counts)
    ASSERT_EQ(StickCounts(FromStickCounts(counts, kFullTilt_rad), kFullTilt_rad), counts);
  for (std::int16_t counts = 0; counts <= 4095; ++counts)
    ASSERT_EQ(ThrustCounts(FromThrustCounts(counts)), counts);
}

// ---------------------------------------------------------------------------------- streams

TEST(AscTecStream, RandomFramesReturnWhateverTheBlocks) {
  Numbers numbers(1);
  Bytes stream, requests;
  for (int i = 0; i < 200; ++i) {
    const Bytes frame = RandomFrame(numbers);
    const auto said = Said(frame);
    ASSERT_EQ(said.size(), 1U);
    Bytes again = Encode(said[0]);
    if (std::holds_alternative<RcData>(said[0])) {
      ASSERT_EQ(again.size(), frame.size());  // the padding's content is not kept
    } else {
      ASSERT_EQ(again, frame);
    }
    stream.insert(stream.end(), frame.begin(), frame.end());
    const CtrlInput input = RandomInput(numbers);
    const Bytes command = Encode(input);
    ASSERT_THAT(Asked(command), ElementsAre(input));
    requests.insert(requests.end(), command.begin(), command.end());
  }
  const auto said = Said(stream);
  const auto asked = Asked(requests);
  EXPECT_EQ(said.size(), 200U);
  EXPECT_EQ(asked.size(), 200U);
  for (const std::size_t block : {1U, 2U, 7U, 64U, 1000U}) {
    TelemetryParser pc;
    CommandParser processor;
    std::vector<Telemetry> telemetry;
    std::vector<Command> commands;
    const auto cut = [block](const Bytes& all, auto& parser, auto& messages) {
      for (std::size_t at = 0; at < all.size(); at += block)
        for (auto& each : parser.Feed(std::span(all).subspan(at, std::min(block, all.size() - at))))
          messages.push_back(each);
    };
    cut(stream, pc, telemetry);
    cut(requests, processor, commands);
    EXPECT_EQ(telemetry, said);
    EXPECT_EQ(commands, asked);
    EXPECT_EQ(pc.counts().skipped_bytes + processor.counts().skipped_bytes, 0U);
  }
}

TEST(AscTecStream, AFrameIsThereWithItsLastByte) {
  const Bytes frame = Encode(ImuCalcData{});
  TelemetryParser parser;
  for (std::size_t i = 0; i + 1 < frame.size(); ++i) ASSERT_TRUE(parser.Feed({&frame[i], 1}).empty());
  EXPECT_EQ(parser.Feed({&frame.back(), 1}).size(), 1U);
}

TEST(AscTecStream, GarbageBeforeBetweenAndAfterLosesNoFrame) {
  Numbers numbers(2);
  // Beginnings of everything, cut and whole: the worst garbage.
  const std::vector<Bytes> garbage = {Text(">"),
                                      Text(">*"),
                                      Text(">*>"),
                                      Text(">*>>*>"),
                                      Text(">a"),
                                      Text(">a>a"),
                                      Joined({Text(">*>"), {92, 0, 0x03}}),
                                      Joined({Text(">*>"), {255, 255, 0x03}}),
                                      Text(">*>d"),
                                      Text(">*>di"),
                                      Text(">*>m"),
                                      Text(">*>p"),
                                      Text("<#<")};
  for (int round = 0; round < 300; ++round) {
    Bytes stream, requests;
    std::vector<Telemetry> frames;
    std::vector<Command> inputs;
    for (int i = 0; i < 4; ++i) {
      const Bytes some =
          numbers() % 2 ? garbage[numbers() % garbage.size()] : Random(numbers, numbers() % 150);
      for (Bytes* each : {&stream, &requests}) each->insert(each->end(), some.begin(), some.end());
      if (i == 3) break;
      const Bytes frame = RandomFrame(numbers);
      frames.push_back(Said(frame).at(0));
      stream.insert(stream.end(), frame.begin(), frame.end());
      inputs.emplace_back(RandomInput(numbers));
      const Bytes command = Encode(inputs.back());
      requests.insert(requests.end(), command.begin(), command.end());
    }
    TelemetryParser pc;
    CommandParser processor;
    ASSERT_EQ(FeedAll(pc, stream), frames) << round;
    ASSERT_EQ(FeedAll(processor, requests), inputs) << round;
  }
}

TEST(AscTecStream, AFalseBeginningHoldsBackForOneFrameAtMost) {
  const Bytes good = Encode(LlStatus{.battery_voltage_1 = 11000});
  TelemetryParser parser;
  parser.Feed(Joined({Text(">*>"), {92, 0, 0x03}}));  // promises 97 bytes more
  std::size_t bytes = 0, frames = 0;
  while (frames == 0) {
    ASSERT_LT(bytes, 103U);
    for (const std::uint8_t byte : good) ++bytes, frames += parser.Feed({&byte, 1}).size();
  }
  EXPECT_EQ(frames, bytes / good.size());  // all that were held back
  EXPECT_EQ(parser.counts().Refused(LinkRefusal::kCheckSum), 1U);
}

TEST(AscTecStream, SilenceGivesUpWhatIsIncompleteAndKeepsWhatIsBehindIt) {
  const LlStatus status{.battery_voltage_1 = 11000};
  TelemetryParser parser;
  EXPECT_TRUE(parser.Feed(Joined({Text(">*>"), {92, 0, 0x03}, Encode(status)})).empty());
  EXPECT_THAT(parser.Idle(), ElementsAre(status));
  EXPECT_EQ(parser.counts().Refused(LinkRefusal::kCut), 1U);
  EXPECT_EQ(parser.counts().skipped_bytes, 6U);
}

TEST(AscTecStream, RefusalsAreCountedByReason) {
  const Bytes good = Encode(LlStatus{});
  const auto counts = [&](auto damage) {
    Bytes frame = good;
    damage(frame);
    TelemetryParser parser;
    EXPECT_TRUE(FeedAll(parser, frame).empty());
    return parser.counts().refused;
  };
  using Counts = std::array<std::uint64_t, kLinkRefusals>;
  EXPECT_EQ(counts([](Bytes& f) { f[5] = 0x31; }), (Counts{1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(counts([](Bytes& f) { f[3] = 17; }), (Counts{0, 1, 0, 0, 0, 0}));
  EXPECT_EQ(counts([](Bytes& f) { f.back() = '>'; }), (Counts{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(counts([](Bytes& f) { f[6] = 1; }), (Counts{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(counts([](Bytes& f) { f.pop_back(); }), (Counts{0, 0, 0, 0, 0, 1}));
  CommandParser parser;
  FeedAll(parser, Joined({Encode(CtrlInput{.thrust = 4096}), Text(">*>p"), {0x00, 0x40}, Text(">*>wh")}));
  EXPECT_EQ(parser.counts().refused, (Counts{1, 0, 0, 0, 2, 0}));
}

TEST(AscTecStream, LengthsAtTheLimits) {
  for (const KindOfFrame& kind : kFrames) {
    for (std::size_t bytes = 0; bytes < 110; ++bytes) {
      const bool right = bytes == kind.bytes || (kind.descriptor == 0x15 && bytes == 33);
      ASSERT_EQ(Said(FrameOf(kind.descriptor, Bytes(bytes, 0x55))).size(), right ? 1U : 0U) << bytes;
    }
    for (const std::uint8_t high : {1, 128, 255}) {  // 256 and more above the right length
      Bytes frame = FrameOf(kind.descriptor, Bytes(kind.bytes, 0x55));
      frame[4] = high;
      ASSERT_TRUE(Said(frame).empty());
    }
  }
}

TEST(AscTecStream, CommandsOutOfRangeAreRefusedAndAtItsEdgesTaken) {
  EXPECT_EQ(Asked(Encode(CtrlInput{2047, -2047, 2047, 4095, 0})).size(), 1U);
  EXPECT_EQ(Asked(Encode(CtrlInput{-2047, 2047, -2047, 0, 0})).size(), 1U);
  for (const CtrlInput& input :
       {CtrlInput{2048, 0, 0, 0, 0}, CtrlInput{0, -2048, 0, 0, 0}, CtrlInput{0, 0, 2048, 0, 0},
        CtrlInput{0, 0, 0, -1, 0}, CtrlInput{0, 0, 0, 4096, 0}})
    EXPECT_TRUE(Asked(Encode(input)).empty());
  EXPECT_EQ(Asked(Encode(Request{kRequestBits})).size(), 1U);
  for (int bit = 0; bit < 16; ++bit) {
    const auto mask = static_cast<std::uint16_t>(1 << bit);
    EXPECT_EQ(Asked(Encode(Request{mask})).size(), mask & kRequestBits ? 1U : 0U) << bit;
  }
}

// ---------------------------------------------------------------------------------- damage

Bytes Flipped(Bytes bytes, std::size_t bit) {
  bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1 << bit % 8);
  return bytes;
}

TEST(AscTecDamage, NoFramePassesWithOneWrongBit) {
  Numbers numbers(3);
  for (const KindOfFrame& kind : kFrames) {
    const Bytes frame = FrameOf(kind.descriptor, Random(numbers, kind.bytes));
    for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit)
      ASSERT_TRUE(Said(Flipped(frame, bit)).empty()) << bit;
  }
}

TEST(AscTecDamage, NoFramePassesWithTwoWrongBitsInDataOrCheckSum) {
  Numbers numbers(4);
  const Bytes frame = FrameOf(0x02, Random(numbers, 16));
  for (std::size_t one = 8 * 6; one < 8 * 24; ++one)
    for (std::size_t other = 8 * 6; other < one; ++other)
      ASSERT_TRUE(Said(Flipped(Flipped(frame, one), other)).empty()) << one << ' ' << other;
}

TEST(AscTecDamage, NoControlCommandPassesWithOneWrongBit) {
  Numbers numbers(5);
  for (int i = 0; i < 50; ++i) {
    const Bytes command = Encode(RandomInput(numbers));
    for (std::size_t bit = 0; bit < 8 * command.size(); ++bit)
      ASSERT_TRUE(Asked(Flipped(command, bit)).empty()) << bit;
  }
}

// What a sum of 16 bits cannot see are two flips of one column that cancel: in the numbers opposite ones, of
// a number and the sum equal ones, in the column of 2^15 any.
TEST(AscTecDamage, OfTwoWrongBitsOfAControlCommandThePassingOnesAreThoseThatTheSumCannotSee) {
  Numbers numbers(6);
  int passed = 0;
  for (int i = 0; i < 20; ++i) {
    const Bytes command = Encode(RandomInput(numbers));
    const auto set = [&](std::size_t bit) { return (command[bit / 8] >> bit % 8 & 1) != 0; };
    for (std::size_t one = 8 * 5; one < 8 * 17; ++one) {
      for (std::size_t other = 8 * 5; other < one; ++other) {
        const bool of_sum = one >= 8 * 15;  // the later of the two; both in the sum cannot share a column
        const bool cancel =
            one % 16 == other % 16 && ((one - 40) % 16 == 15 || (set(one) != set(other)) != of_sum);
        const Bytes damaged = Flipped(Flipped(command, one), other);
        Reader reader(std::span<const std::uint8_t>(damaged).subspan(5));
        bool in_range = true;
        for (int k = 0; k < 3; ++k) in_range &= std::abs(reader.Read<std::int16_t>()) <= 2047;
        const int thrust = reader.Read<std::int16_t>();
        in_range &= thrust >= 0 && thrust <= 4095;
        const bool pass = !Asked(damaged).empty();
        ASSERT_EQ(pass, cancel && in_range) << one << ' ' << other;
        passed += pass;
      }
    }
  }
  EXPECT_GT(passed, 0);
}

TEST(AscTecDamage, UnprotectedBitsAreThoseThatTheHeaderNames) {
  int passed = 0;
  const Bytes acknowledgement = Encode(Acknowledgement{0x17});
  for (std::size_t bit = 0; bit < 40; ++bit) passed += !Said(Flipped(acknowledgement, bit)).empty();
  EXPECT_EQ(passed, 8);  // its descriptor's
  passed = 0;
  const Bytes request = Encode(Request{0x0204});
  for (std::size_t bit = 0; bit < 48; ++bit) passed += !Asked(Flipped(request, bit)).empty();
  EXPECT_EQ(passed, std::popcount(kRequestBits));
  Bytes status = Encode(LlStatus{});
  status[5] = CtrlOut::kDescriptor;
  EXPECT_THAT(Said(status), ElementsAre(CtrlOut{}));
}

// Data that has nothing to do with its check sum passes once in 2^16; the bounds are 5 deviations of Poisson.
TEST(AscTecDamage, RandomDataPassesAtTheRateOfItsSum) {
  Numbers numbers(7);
  constexpr int kTrials = 500'000;
  const double mean = kTrials / 65536.0, bound = 5 * std::sqrt(mean);
  Bytes frame = Encode(LlStatus{}), command = Encode(CtrlInput{});
  TelemetryParser pc;
  CommandParser processor;
  int frames = 0, commands = 0;
  for (int i = 0; i < kTrials; ++i) {
    const std::uint64_t some = numbers();
    for (std::size_t k = 0; k < 4; ++k) {
      const auto byte = static_cast<std::uint8_t>(some >> 8 * k);
      frame[20 + k] = command[13 + k] = byte;  // the last number and the sum: up_time, ctrl
    }
    frames += static_cast<int>(FeedAll(pc, frame).size());
    commands += static_cast<int>(FeedAll(processor, command).size());
  }
  EXPECT_NEAR(frames, mean, bound);
  EXPECT_NEAR(commands, mean, bound);
}

Bytes Mutated(Numbers& numbers, Bytes bytes) {
  const auto place = [&] { return bytes.begin() + static_cast<std::ptrdiff_t>(numbers() % bytes.size()); };
  switch (numbers() % 6) {
    case 0:
      return Random(numbers, numbers() % 60);
    case 1:
      bytes.erase(place());
      break;
    case 2:
      bytes.insert(place(), static_cast<std::uint8_t>(numbers()));
      break;
    case 3:
      bytes.erase(place(), bytes.end());
      break;
    case 4:
      bytes.erase(bytes.begin(), place());
      break;
    default:
      for (std::uint64_t i = 0; i <= numbers() % 8; ++i) *place() = static_cast<std::uint8_t>(numbers());
  }
  return bytes;
}

bool Contains(const Bytes& all, const Bytes& part) {
  return std::search(all.begin(), all.end(), part.begin(), part.end()) != all.end();
}

// One damaged and one good frame in turn, a million of the damaged in all: every good one arrives, and of the
// damaged no more than the sums let through.
TEST(AscTecDamage, AMillionDamagedFramesLeaveEveryGoodOneReadable) {
  Numbers numbers(8);
  constexpr int kTrials = 500'000;
  TelemetryParser pc;
  CommandParser processor;
  int damaged_frames = 0, damaged_commands = 0;
  for (int i = 0; i < kTrials; ++i) {
    const LlStatus status{.cpu_load = static_cast<std::int16_t>(i),
                          .up_time = static_cast<std::int16_t>(i >> 16)};
    const Bytes frame = RandomFrame(numbers), bad_frame = Mutated(numbers, frame);
    const auto said = FeedAll(pc, Joined({bad_frame, Encode(status)}));
    ASSERT_FALSE(said.empty()) << i;
    ASSERT_EQ(said.back(), Telemetry(status)) << i;
    if (said.size() > 1 && !Contains(bad_frame, frame)) damaged_frames += static_cast<int>(said.size()) - 1;

    const CtrlInput input = RandomInput(numbers);
    const Bytes command = Encode(RandomInput(numbers)), bad_command = Mutated(numbers, command);
    const auto asked = FeedAll(processor, Joined({bad_command, Encode(input)}));
    ASSERT_FALSE(asked.empty()) << i;
    ASSERT_EQ(asked.back(), Command(input)) << i;
    if (asked.size() > 1 && !Contains(bad_command, command)) {
      ++damaged_commands;
      ASSERT_EQ(asked.size(), 2U);
      ASSERT_EQ(bad_command.size(), kCtrlInputBytes);
      Reader reader(std::span<const std::uint8_t>(bad_command).subspan(5));
      int sum = 0xAAAA;
      for (int k = 0; k < 5; ++k) sum += reader.Read<std::int16_t>();
      ASSERT_EQ(reader.Read<std::uint16_t>(), sum & 0xFFFF);
    }
  }
  std::cout << "accepted though damaged, of " << kTrials << " each: " << damaged_frames << " frames, "
            << damaged_commands << " commands\n";
  constexpr double kMean = kTrials / 65536.0;
  EXPECT_LE(damaged_frames, kMean + 5 * std::sqrt(kMean));
  // Two wrong bytes of one column cancel once in 256, and one command in a hundred or fewer has just those.
  EXPECT_LE(damaged_commands, kTrials / 100 / 256.0 + 5 * std::sqrt(kTrials / 100 / 256.0));
}

}  // namespace
}  // namespace kestrel::control::wire
