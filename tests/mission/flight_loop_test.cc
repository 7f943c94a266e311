// SPDX-License-Identifier: Apache-2.0
#include "mission/flight_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace kestrel::mission {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The three sides of the loop; each writes down when it was called.
struct Fakes final : public vision::Camera, public control::Autopilot, public Mission {
  std::vector<std::string> calls;
  int frames = 1;
  control::VehicleState state;
  vision::Frame frame;
  std::vector<Decision> decisions = {{}};  // one for each frame, the last for all that follow
  std::size_t steps = 0;
  std::vector<control::Setpoint> sent;

  std::optional<vision::Frame> Next() override {
    calls.push_back("next");
    if (frames-- == 0) return std::nullopt;
    ++frame.sequence;
    return frame;
  }
  control::VehicleState State() const override {
    const_cast<Fakes*>(this)->calls.push_back("state");
    return state;
  }
  void Send(const control::Setpoint& setpoint) override {
    calls.push_back("send");
    sent.push_back(setpoint);
  }
  void Aid(const control::AttitudeAid& aid) override {
    calls.push_back("aid");
    EXPECT_EQ(aid.sigma, decisions[steps - 1].aid->sigma);
  }
  Decision Step(const vision::Frame& seen, const control::VehicleState& s) override {
    calls.push_back("step");
    EXPECT_EQ(seen.sequence, frame.sequence);
    EXPECT_EQ(s.t_s, state.t_s);
    return decisions[std::min(steps++, decisions.size() - 1)];
  }
  void Draw(cv::Mat&) const override {}

  bool go_on = true;
  std::string Run() {
    return Fly(*this, *this, *this,
               [&](const vision::Frame& given, const control::VehicleState& heard, const Decision& decided) {
                 RequireNumbers(given, heard, decided);
                 calls.push_back("record");
                 return go_on;
               });
  }
  std::string Complaint() {
    try {
      Run();
    } catch (const NotANumber& e) {
      return e.what();
    }
    return "";
  }
};

TEST(FlightLoop, EachFrameIsSeenDecidedSentAndRecordedInThatOrder) {
  Fakes f;
  f.frames = 2;
  f.decisions[0].setpoint = control::VelocitySetpoint{{1, 2, 3}, 4};
  EXPECT_EQ(f.Run(), "");
  EXPECT_THAT(f.calls, ElementsAre("next", "state", "step", "send", "record", "next", "state", "step", "send",
                                   "record", "next"));
  ASSERT_EQ(f.sent.size(), 2u);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(f.sent[0]).v_H, Eigen::Vector3d(1, 2, 3));
}

TEST(FlightLoop, AnAttitudeGoesOutBeforeTheSetpointThatIsFlownByIt) {
  Fakes f;
  f.decisions[0].setpoint = control::VelocitySetpoint{};
  f.decisions[0].aid = control::AttitudeAid{Eigen::Quaterniond::Identity(), 0.25};
  EXPECT_EQ(f.Run(), "");
  EXPECT_THAT(f.calls, ElementsAre("next", "state", "step", "aid", "send", "record", "next"));
  f.frames = 1, f.steps = 0;
  f.decisions[0].aid->R_NB.x() = kNaN;
  EXPECT_THAT(f.Complaint(), HasSubstr("the attitude aid is not a number"));
}

TEST(FlightLoop, WithoutASetpointNothingIsSent) {
  Fakes f;
  EXPECT_EQ(f.Run(), "");
  EXPECT_THAT(f.calls, ElementsAre("next", "state", "step", "record", "next"));
}

TEST(FlightLoop, AnOutcomeEndsTheFlightAfterItsSetpointAndRecord) {
  Fakes f;
  f.frames = 10;
  f.decisions.resize(3);
  f.decisions[2].outcome = "landed";
  f.decisions[2].setpoint = control::VelocitySetpoint{};
  EXPECT_EQ(f.Run(), "landed");
  EXPECT_EQ(f.steps, 3u);
  EXPECT_EQ(f.sent.size(), 1u);
  EXPECT_EQ(f.calls.back(), "record");
}

TEST(FlightLoop, TheRecordMayEndIt) {
  Fakes f;
  f.frames = 10;
  f.go_on = false;
  EXPECT_EQ(f.Run(), "");
  EXPECT_EQ(f.steps, 1u);
}

TEST(FlightLoop, MeasuresTheControlWithoutTheVision) {
  Fakes f;
  f.decisions[0].vision_s = -5;  // as if the image had taken that much less than nothing
  double control_s = 0;
  Fly(f, f, f, [&](const vision::Frame&, const control::VehicleState&, const Decision& d) {
    control_s = d.control_s;
    return true;
  });
  EXPECT_GE(control_s, 5);
  EXPECT_LT(control_s, 6);
}

TEST(FlightLoop, AStateThatIsNoNumberIsNamed) {
  const struct {
    void (*spoil)(Fakes&);
    const char* name;
  } cases[] = {
      {[](Fakes& f) { f.state.p_NB.y() = kNaN; }, "the autopilot's position"},
      {[](Fakes& f) { f.state.v_N.z() = kNaN; }, "the autopilot's velocity"},
      {[](Fakes& f) { f.state.R_NB.w() = kNaN; }, "the autopilot's attitude"},
      {[](Fakes& f) { f.state.w_B.x() = std::numeric_limits<double>::infinity(); },
       "the autopilot's angular rate"},
      {[](Fakes& f) { f.frame.t_s = kNaN; }, "the frame's time"},
  };
  for (const auto& c : cases) {
    Fakes f;
    f.frame.t_s = 1.25, f.state.t_s = 1.25;
    c.spoil(f);
    EXPECT_EQ(f.Complaint(), std::string("at 1.250 s: ") + c.name + " is not a number");
  }
}

TEST(FlightLoop, ADecisionThatIsNoNumberIsNamed) {
  TargetFix bad_position, bad_yaw;
  bad_position.p_TB.z() = kNaN, bad_yaw.yaw_TB = kNaN;
  std::vector<std::pair<Decision, const char*>> cases(10);
  cases[0].first.fix = bad_position, cases[0].second = "the measured position";
  cases[1].first.fix = bad_yaw, cases[1].second = "the measured yaw";
  const std::pair<control::Setpoint, const char*> setpoints[] = {
      {control::VelocitySetpoint{{0, kNaN, 0}, 0}, "the velocity setpoint"},
      {control::VelocitySetpoint{{0, 0, 0}, kNaN}, "the velocity setpoint"},
      {control::PositionSetpoint{{kNaN, 0, 0}, 0}, "the position setpoint"},
      {control::PositionSetpoint{{0, 0, 0}, kNaN}, "the position setpoint"},
      {control::AttitudeSetpoint{kNaN, 0, 0, 0}, "the attitude setpoint"},
      {control::AttitudeSetpoint{0, kNaN, 0, 0}, "the attitude setpoint"},
      {control::AttitudeSetpoint{0, 0, kNaN, 0}, "the attitude setpoint"},
      {control::AttitudeSetpoint{0, 0, 0, kNaN}, "the attitude setpoint"},
  };
  for (std::size_t i = 0; i < 8; ++i)
    cases[i + 2].first.setpoint = setpoints[i].first, cases[i + 2].second = setpoints[i].second;
  for (const auto& [decision, name] : cases) {
    Fakes f;
    f.decisions = {decision};
    f.frame.t_s = 3.5;
    EXPECT_EQ(f.Complaint(), std::string("at 3.500 s: ") + name + " is not a number");
  }
}

TEST(FlightLoop, AStreamThatIsEmptyIsNoFlight) {
  Fakes f;
  f.frames = 0;
  EXPECT_EQ(f.Run(), "");
  EXPECT_EQ(f.steps, 0u);
}

}  // namespace
}  // namespace kestrel::mission
