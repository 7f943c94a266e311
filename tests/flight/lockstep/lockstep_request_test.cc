// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "flight/lockstep/lockstep_reply.h"

namespace kestrel::flight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// What it is refused with, "kind: message".
std::string Refusal(const std::string& json) {
  try {
    ParseLockstepRequest(json);
  } catch (const LockstepError& e) {
    return std::string(e.kind) + ": " + e.what();
  }
  return "taken";
}

StepRequest StepWith(const std::string& setpoint) {
  return std::get<StepRequest>(
      ParseLockstepRequest(R"({"request":"step","token":1,"setpoint":)" + setpoint + "}").body);
}

TEST(LockstepRequest, TakesEachKindOfSetpoint) {
  const auto velocity = std::get<control::VelocitySetpoint>(
      *StepWith(R"({"kind":"velocity","v_H_m_s":[1,2,-3.5],"yaw_rate_rad_s":0.25})").setpoint);
  EXPECT_EQ(velocity.v_H, Eigen::Vector3d(1, 2, -3.5));
  EXPECT_EQ(velocity.yaw_rate, 0.25);
  const auto position = std::get<control::PositionSetpoint>(
      *StepWith(R"({"kind":"position","p_N_m":[1,2,-3],"yaw_rad":1e-3})").setpoint);
  EXPECT_EQ(position.p_N, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(position.yaw, 1e-3);
  const auto attitude = std::get<control::AttitudeSetpoint>(
      *StepWith(R"({"kind":"attitude","roll_rad":0.1,"pitch_rad":-0.2,"yaw_rate_rad_s":0.3,"thrust":0.4})")
           .setpoint);
  EXPECT_EQ(attitude.roll, 0.1);
  EXPECT_EQ(attitude.pitch, -0.2);
  EXPECT_EQ(attitude.yaw_rate, 0.3);
  EXPECT_EQ(attitude.thrust, 0.4);
  const auto rates = std::get<control::RateSetpoint>(
      *StepWith(R"({"kind":"rates","w_B_rad_s":[0.1,0.2,0.3],"thrust":0.5})").setpoint);
  EXPECT_EQ(rates.w_B, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(rates.thrust, 0.5);
  EXPECT_FALSE(StepWith("null").setpoint);
}

// A setpoint goes through the text of the protocol and back with every bit, those of no short decimal too.
TEST(LockstepRequest, ADecisionComesBackBitForBit) {
  mission::Decision decision;
  const Eigen::Vector3d v(1.0 / 3, -0.1 - 0.2, 5e-324);
  decision.setpoint = control::VelocitySetpoint{v, -0.0};
  decision.aid = control::AttitudeAid{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), 0.1 / 3};
  const auto json = LockstepJson(decision);
  const auto step = std::get<StepRequest>(ParseLockstepRequest(R"({"request":"step","token":1,"setpoint":)" +
                                                               json["setpoint"].dump() + R"(,"aid":)" +
                                                               json["aid"].dump() + "}")
                                              .body);
  const auto back = std::get<control::VelocitySetpoint>(*step.setpoint);
  EXPECT_EQ(back.v_H, v);
  EXPECT_TRUE(std::signbit(back.yaw_rate));
  EXPECT_EQ(step.aid->R_NB.coeffs(), decision.aid->R_NB.coeffs());
  EXPECT_EQ(step.aid->sigma, decision.aid->sigma);
}

TEST(LockstepRequest, TakesAWholeNumberAsALanguageOfOneKindOfNumberWritesIt) {
  EXPECT_EQ(ParseLockstepRequest(R"({"request":"decide","token":3.0})").token, 3u);
  const auto reset = ParseLockstepRequest(R"({"request":"reset","token":1,"seed":18446744073709551615})");
  EXPECT_EQ(std::get<ResetRequest>(reset.body).seed, 18446744073709551615u);
}

TEST(LockstepRequest, SaysWhatIsWrong) {
  EXPECT_THAT(Refusal("GET / HTTP/1.1"), HasSubstr("message: the message is no JSON"));
  EXPECT_THAT(Refusal("[1,2]"), HasSubstr("message: "));
  EXPECT_THAT(Refusal(R"({"request":7})"), HasSubstr("message: "));
  EXPECT_THAT(Refusal(R"({"request":"stp","token":1})"), AllOf(HasSubstr("request: "), HasSubstr("step")));
  EXPECT_THAT(Refusal(R"({"request":"hello"})"), HasSubstr("version: hello.version is missing"));
  EXPECT_THAT(Refusal(R"({"request":"hello","version":2})"),
              HasSubstr("version: hello.version is 2: this server speaks version 1"));
  EXPECT_THAT(Refusal(R"({"request":"step","token":-1})"), HasSubstr("step.token is no whole number"));
  EXPECT_THAT(Refusal(R"({"request":"step","token":1.5})"), HasSubstr("step.token is no whole number"));
  EXPECT_THAT(Refusal(R"({"request":"step","token":1,"setpont":{}})"),
              AllOf(HasSubstr("step has no key 'setpont'"), HasSubstr("setpoint")));
  const auto step = [](const std::string& setpoint) {
    return Refusal(R"({"request":"step","token":1,"setpoint":)" + setpoint + "}");
  };
  EXPECT_THAT(step("7"), HasSubstr("setpoint.kind is missing"));
  EXPECT_THAT(step(R"({"kind":"warp"})"), HasSubstr("setpoint.kind is 'warp'"));
  EXPECT_THAT(step(R"({"kind":"velocity","v_H_m_s":[1,2],"yaw_rate_rad_s":0})"),
              HasSubstr("setpoint.v_H_m_s is no list of 3 numbers"));
  EXPECT_THAT(step(R"({"kind":"velocity","v_H_m_s":[1,2,null],"yaw_rate_rad_s":0})"),
              HasSubstr("setpoint.v_H_m_s[2] is no number"));
  EXPECT_THAT(step(R"({"kind":"velocity","v_H_m_s":[1,2,NaN],"yaw_rate_rad_s":0})"), HasSubstr("no JSON"));
  EXPECT_THAT(step(R"({"kind":"velocity","v_H_m_s":[1,2,1e999],"yaw_rate_rad_s":0})"), HasSubstr("no JSON"));
  EXPECT_THAT(step(R"({"kind":"velocity","v_H_m_s":[1,2,3]})"),
              HasSubstr("setpoint.yaw_rate_rad_s is missing"));
  EXPECT_THAT(Refusal(R"({"request":"step","token":1,"aid":{"q_NB":[1,1,0,0],"sigma_rad":0}})"),
              HasSubstr("aid.q_NB has the length 1.41421"));
  EXPECT_THAT(Refusal(R"({"request":"advance","token":1})"), HasSubstr("advance.duration_s is missing"));
  EXPECT_THAT(Refusal(R"({"request":"finish","token":1,"outcome":"a\u001b[2J"})"),
              HasSubstr("characters that cannot be shown"));
  EXPECT_THAT(Refusal(R"({"request":"reset","token":1,"images":false,"surfaces":true})"),
              HasSubstr("reset.surfaces are of images"));
}

TEST(LockstepRequest, ADeepNestIsRefusedWithoutHarm) {
  EXPECT_THAT(Refusal(std::string(kLongestRequest, '[')), HasSubstr("no JSON"));
  const std::string half(kLongestRequest / 2, '[');
  EXPECT_THAT(Refusal(half + std::string(half.size(), ']')), HasSubstr("message: "));
}

}  // namespace
}  // namespace kestrel::flight
