// SPDX-License-Identifier: Apache-2.0
#include "records/log/identification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>

namespace kestrel::records {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// An answer of known dead time, lag and gain, integrated at a step of its own, with noise.
Asked Answered(double delay_s, double lag_s, double gain, double duration_s, std::uint32_t seed) {
  Asked asked;
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0, 0.03);
  constexpr double kStep_s = 0.001;
  double x = 0;
  const auto wanted_at = [](double t) {
    return t < 0 ? 0.0 : std::sin(0.9 * std::floor(t / 1.5) * std::floor(t / 1.5));
  };
  for (int i = 0; i * kStep_s < duration_s; ++i) {
    const double t = i * kStep_s;
    x += kStep_s / lag_s * (wanted_at(t - delay_s) - x);
    if (i % 33 == 0) asked.wanted_s.push_back(t), asked.wanted.push_back(wanted_at(t));
    if (i % 20 == 7) asked.flown_s.push_back(t), asked.flown.push_back(0.4 + gain * x + noise(rng));
  }
  return asked;
}

TEST(Identification, AKnownAnswerIsRecoveredWithinItsDeviation) {
  int cases = 0;
  for (const double delay : {0.0, 0.1, 0.4}) {
    for (const double lag : {0.1, 0.3, 0.8}) {
      std::string why;
      const Response r =
          FitResponse(Answered(delay, lag, 0.85, 60, 500 + static_cast<std::uint32_t>(cases++)), 0.1, why);
      ASSERT_EQ(why, "") << delay << ' ' << lag;
      // the command is known to one of its own steps, 0.033 s
      EXPECT_NEAR(r.late_s.value, delay + lag, 4 * r.late_s.sd + 0.033) << delay << ' ' << lag;
      EXPECT_LT(r.late_s.sd, 0.05);
      EXPECT_NEAR(r.gain.value, 0.85, 4 * r.gain.sd + 0.01) << delay << ' ' << lag;
      EXPECT_LT(r.gain.sd, 0.05);
    }
  }
  EXPECT_EQ(cases, 9);
}

TEST(Identification, ALogThatDoesNotTellSaysWhy) {
  std::string why;
  FitResponse(Answered(0.1, 0.2, 1, 5, 3), 0.1, why);
  EXPECT_THAT(why, HasSubstr("and 8 s are needed"));
  FitResponse(Answered(0.1, 0.2, 1, 60, 3), 10, why);
  EXPECT_THAT(why, HasSubstr("hardly moved"));
  Asked unrelated = Answered(0.1, 0.2, 1, 60, 3);
  std::mt19937 rng(8);
  std::normal_distribution<double> noise;
  for (double& each : unrelated.flown) each = noise(rng);
  why.clear();
  FitResponse(unrelated, 0.1, why);
  EXPECT_THAT(why, HasSubstr("50 % are needed"));
}

template <class T>
void Put(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void PutUlog(std::string& to, char type, const std::string& body) {
  Put(to, static_cast<std::uint16_t>(body.size()));
  to += type + body;
}

std::string UlogData(std::uint16_t id, std::uint64_t us, std::initializer_list<float> values) {
  std::string body;
  Put(body, id);
  Put(body, us);
  for (const float each : values) Put(body, each);
  return body;
}

TEST(Identification, ReadsAUlogWithNestedAndRepeatedFields) {
  std::string log("ULog\x01\x12\x35\x01", 8);
  Put(log, std::uint64_t{0});
  PutUlog(log, 'B', std::string(40, '\0'));
  PutUlog(log, 'F', "inner:float a;float[2] b;");
  PutUlog(log, 'F', "outer:uint64_t timestamp;inner c;uint8_t[4] _padding0;");
  PutUlog(log, 'A', std::string("\0\x05\0", 3) + "outer");
  PutUlog(log, 'A', std::string("\x01\x06\0", 3) + "outer");
  PutUlog(log, 'D', UlogData(5, 2500000, {1, 2, 3}));
  PutUlog(log, 'D', UlogData(6, 2600000, {7, 8, 9}));  // another instance
  PutUlog(log, 'D', UlogData(5, 3500000, {4, 5, 6}));
  log += "\x20";  // cut off
  const LogTables tables = ReadUlog(log);
  ASSERT_EQ(tables.count("outer"), 1u);
  const LogTable& outer = tables.at("outer");
  EXPECT_THAT(outer.at("t_s"), testing::ElementsAre(2.5, 3.5));
  EXPECT_THAT(outer.at("c.a"), testing::ElementsAre(1, 4));
  EXPECT_THAT(outer.at("c.b[1]"), testing::ElementsAre(3, 6));
  EXPECT_THROW(ReadUlog("no log"), std::runtime_error);
}

TEST(Identification, ReadsADataFlashLogOverDamage) {
  const auto padded = [](std::string text, std::size_t size) { return text.resize(size, '\0'), text; };
  std::string log = std::string("\xA3\x95\x80\x2A\x0F", 5) + padded("ATT", 4) + padded("Qcc", 16) +
                    padded("TimeUS,DesRoll,Roll", 64);  // 3 + 8 + 2 + 2 bytes
  const auto row = [&](std::uint64_t us, std::int16_t wanted, std::int16_t flown) {
    log += "\xA3\x95\x2A";
    Put(log, us), Put(log, wanted), Put(log, flown);
  };
  row(1000000, 250, -130);
  log += "junk";
  row(1100000, 300, -100);
  const LogTables tables = ReadDataFlash(log);
  EXPECT_THAT(tables.at("ATT").at("t_s"), testing::ElementsAre(1.0, testing::DoubleEq(1.1)));
  EXPECT_THAT(tables.at("ATT").at("DesRoll"), testing::ElementsAre(2.5, 3.0));
  EXPECT_THAT(tables.at("ATT").at("Roll"), testing::ElementsAre(-1.3, -1.0));
  EXPECT_THROW(ReadDataFlash("no log"), std::runtime_error);
}

// From the tables of a log: hover thrust, the lateness of a velocity, and the reasons for the rest.
TEST(Identification, TellsWhatALogHoldsAndWhatItDoesNot) {
  const Asked asked = Answered(0.1, 0.3, 1, 60, 77);
  LogTables px4;
  px4["vehicle_local_position_setpoint"] = {{"t_s", asked.wanted_s}, {"vx", asked.wanted}};
  px4["vehicle_local_position"] = {
      {"t_s", asked.flown_s}, {"vx", asked.flown}, {"vz", std::vector<double>(asked.flown.size(), 0.02)}};
  px4["vehicle_attitude_setpoint"] = {{"t_s", asked.wanted_s},
                                      {"thrust_body[2]", std::vector<double>(asked.wanted.size(), -0.43)}};
  int found = 0, missing = 0;
  for (const Identified& each : IdentifyUlog(px4)) {
    if (each.name == "hover thrust") {
      EXPECT_NEAR(each.value.value, 0.43, 1e-9);
      ++found;
    }
    if (each.name == "velocity north, late by") {
      EXPECT_THAT(each.missing, IsEmpty());
      EXPECT_NEAR(each.value.value, 0.4, 4 * each.value.sd + 0.033);
      ++found;
    }
    if (each.name == "velocity east, late by") {
      EXPECT_EQ(each.missing, "the log holds no vehicle_local_position_setpoint.vy");
      ++missing;
    }
    if (each.name == "roll, late by") {
      EXPECT_THAT(each.missing, HasSubstr("q_d"));
      ++missing;
    }
  }
  EXPECT_EQ(found, 2);
  EXPECT_EQ(missing, 2);
}

}  // namespace
}  // namespace kestrel::records
