// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/ardupilot_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

namespace kestrel::sim::ardupilot {
namespace {

using control::wire::Bytes;

TEST(ArduPilotJson, ServoPacketsAreReadByTheirLayout) {
  Bytes bytes{0x1A, 0x48, 0xB0, 0x04, 0x78, 0x56, 0x34, 0x12};  // 18458, 1200, 0x12345678
  for (int i = 0; i < 16; ++i) bytes.insert(bytes.end(), {static_cast<std::uint8_t>(i), 0x04});
  ASSERT_EQ(bytes.size(), 40U);
  std::optional<ServoPacket> packet = DecodeServoPacket(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->frame_rate_hz, 1200);
  EXPECT_EQ(packet->frame_count, 0x12345678U);
  EXPECT_EQ(packet->channels, 16);
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(packet->pwm_us[i], i < 16 ? 1024 + i : 0);
  EXPECT_EQ(EncodeServoPacket(*packet), bytes);

  bytes[0] = 0x81, bytes[1] = 0x73;  // 29569
  EXPECT_FALSE(DecodeServoPacket(bytes));
  for (int i = 16; i < 32; ++i) bytes.insert(bytes.end(), {static_cast<std::uint8_t>(i), 0x04});
  ASSERT_EQ(bytes.size(), 72U);
  packet = DecodeServoPacket(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->channels, 32);
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(packet->pwm_us[i], 1024 + i);
  EXPECT_EQ(EncodeServoPacket(*packet), bytes);
}

TEST(ArduPilotJson, WhatIsNoServoPacketIsRefused) {
  const Bytes good = EncodeServoPacket({});
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(DecodeServoPacket(std::span(good).first(length)));
  Bytes bad = good;
  bad.push_back(0);
  EXPECT_FALSE(DecodeServoPacket(bad));
  bad = good, bad[1] ^= 1;
  EXPECT_FALSE(DecodeServoPacket(bad));
}

TEST(ArduPilotJson, RepeatsResetsAndGapsAreToldApart) {
  ServoSequence sequence;
  EXPECT_EQ(sequence.Classify(5), ServoEvent::kReset);
  EXPECT_EQ(sequence.Classify(6), ServoEvent::kNext);
  EXPECT_EQ(sequence.Classify(6), ServoEvent::kRepeat);
  EXPECT_EQ(sequence.Classify(7), ServoEvent::kNext);
  EXPECT_EQ(sequence.missed(), 0U);
  EXPECT_EQ(sequence.Classify(10), ServoEvent::kNext);
  EXPECT_EQ(sequence.missed(), 2U);
  EXPECT_EQ(sequence.Classify(0), ServoEvent::kReset);
  EXPECT_EQ(sequence.Classify(1), ServoEvent::kNext);
  ServoSequence round;
  round.Classify(0xFFFFFFFF);
  EXPECT_EQ(round.Classify(0), ServoEvent::kNext);
}

PhysicsState Example() {
  return {.t_s = 2500.0025,
          .w_B = {0.1, -0.2, 1e-7},
          .specific_force_B = {1, 2, -9.8},
          .p_N = {1.0 / 3, -2e6, -30},
          .v_N = {4, 5, 6},
          .R_NB = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5),
          .ranges_m = {1.5, 2.5},
          .wind_N = Eigen::Vector3d(7, 8, 9),
          .airspeed_m_s = 11.25,
          .rc_us = {1500, 1501, 1502, 1503, 1504, 1505, 1506, 1507, 1508, 1509}};
}

TEST(ArduPilotJson, TheStateIsALineOfJson) {
  const std::string line = StateLine(Example()).value();
  EXPECT_EQ(line.front(), '\n');
  EXPECT_EQ(line.back(), '\n');
  EXPECT_EQ(line.find('\n', 1), line.size() - 1);
  EXPECT_EQ(line.find(' '), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(line);
  using List = std::vector<double>;
  EXPECT_EQ(json["timestamp"], 2500.0025);
  EXPECT_EQ(json["imu"]["gyro"], (List{0.1, -0.2, 1e-7}));
  EXPECT_EQ(json["imu"]["accel_body"], (List{1, 2, -9.8}));
  EXPECT_EQ(json["position"], (List{1.0 / 3, -2e6, -30}));
  EXPECT_EQ(json["velocity"], (List{4, 5, 6}));
  EXPECT_EQ(json["quaternion"], (List{0.5, -0.5, 0.5, -0.5}));
  EXPECT_EQ(json["rng_1"], 1.5);
  EXPECT_EQ(json["rng_2"], 2.5);
  EXPECT_EQ(json["velocity_wind"], (List{7, 8, 9}));
  EXPECT_EQ(json["airspeed"], 11.25);
  EXPECT_EQ(json["rc"]["rc_10"], 1509);
  EXPECT_EQ(json.size(), 10U);
}

TEST(ArduPilotJson, TheLeastState) {
  PhysicsState state;
  state.specific_force_B.z() = -9.5;
  EXPECT_EQ(StateLine(state),
            "\n{\"timestamp\":0,\"imu\":{\"gyro\":[0,0,0],\"accel_body\":[0,0,-9.5]},\"position\":[0,0,0],"
            "\"quaternion\":[1,0,0,0],\"velocity\":[0,0,0]}\n");
}

// What ArduPilot gets: it looks for the first place where the section's name is, for the first place after it
// where the key's is, and reads numbers two characters further on.
const char* Found(const std::string& line, const std::string& section, const std::string& key) {
  const std::size_t at = line.find(key, line.find(section) + section.size() + 1);
  return at == std::string::npos ? "" : line.c_str() + at + key.size() + 2;
}

TEST(ArduPilotJson, ItsSearchFindsEveryNumber) {
  const std::string line = StateLine(Example()).value();
  const auto three = [&line](const std::string& section, const std::string& key) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    EXPECT_EQ(std::sscanf(Found(line, section, key), "[%lf, %lf, %lf]", &v.x(), &v.y(), &v.z()), 3) << key;
    return v;
  };
  EXPECT_EQ(std::atof(Found(line, "", "timestamp")), 2500.0025);
  EXPECT_EQ(three("imu", "gyro"), Eigen::Vector3d(0.1, -0.2, 1e-7));
  EXPECT_EQ(three("imu", "accel_body"), Eigen::Vector3d(1, 2, -9.8));
  EXPECT_EQ(three("", "position"), Eigen::Vector3d(1.0 / 3, -2e6, -30));
  EXPECT_EQ(three("", "velocity"), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(three("", "velocity_wind"), Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(std::atof(Found(line, "", "rng_2")), 2.5);
  EXPECT_EQ(std::atof(Found(line, "", "airspeed")), 11.25);
  EXPECT_EQ(std::atof(Found(line, "rc", "rc_1")), 1500);
  EXPECT_EQ(std::atof(Found(line, "rc", "rc_10")), 1509);
}

TEST(ArduPilotJson, WhatIsNoNumberIsNotSent) {
  PhysicsState state;
  state.v_N.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(StateLine(state));
  state = {}, state.t_s = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(StateLine(state));
  state = {}, state.airspeed_m_s = NAN;
  EXPECT_FALSE(StateLine(state));
  EXPECT_TRUE(StateLine({}));
}

}  // namespace
}  // namespace kestrel::sim::ardupilot
